// What: a model with candidates turned static beside the model as it is, image by image.
// Not: sums over pixels (kernels/stages/sensitivity).
#include "recon4d/reduction/static_demotion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/base/parallel.h"
#include "kernels/elements/load_gaussian.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/set_rows.h"
#include "recon4d/model/shape3.h"
#include "recon4d/model/validity.h"

namespace tessera {
namespace {

constexpr int64_t kPixelGrain = 1 << 15, kGaussianGrain = 2048;  // per task

template <Form form>
void place_still(const GaussianSpans<const float>& from, const ColourRules<float>& colours,
                 int64_t n, float timestep, float opacity, const GaussianSpans<float>& to) {
  std::copy_n(from.at(kMean, n), 3, to.at(kMean, n));
  std::copy_n(from.at(kLogScale, n), 3, to.at(kLogScale, n));
  std::copy_n(from.at(kRotation, n), 4, to.at(kRotation, n));
  std::copy_n(from.at(kSh, n), from.width(kSh), to.at(kSh, n));
  *to.at(kOpacityLogit, n) = *from.at(kOpacityLogit, n);
  GaussianState<float> g;
  if (!(opacity > 0) || !load_gaussian<form>(from, n, g)) return;
  const Slice<float> slice = slice_at(g.mean, g.spacetime, timestep);
  float room[3 * kMaxShCoefficients];
  std::copy_n(sh_at(colours, g, slice.delta, room), colours.scalars(), to.at(kSh, n));
  const Sym3<float>& c = g.spacetime.covariance;
  const Shape3 shape = shape_of(Sym3<double>{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz});
  for (int k = 0; k < 3; ++k) {
    to.at(kMean, n)[k] = slice.mean[k];
    to.at(kLogScale, n)[k] = float(shape.log_scale[k]);
  }
  for (int k = 0; k < 4; ++k) to.at(kRotation, n)[k] = float(shape.rotation[k]);
  *to.at(kOpacityLogit, n) = logit(std::clamp(opacity, 1e-4f, 1 - 1e-6f));
}

/// Static Gaussians of `model`, then `added`; dynamic ones but `without`.
GaussianModel tried(const GaussianModel& model, const GaussianSet& added,
                    const std::vector<int64_t>& without) {
  GaussianModel trial = model.clone_values();
  append_rows(trial.static_set, added);
  trial.dynamic_set = select_rows(model.dynamic_set, rows_but(model.dynamic_set.count(), without));
  return trial;
}

constexpr int64_t kBatch = 4;  // frames drawn at once

template <class Look>
void for_each_batch(const FrameSample& at, Look&& look) {
  for (int64_t begin = 0; begin < at.count(); begin += kBatch)
    look(begin, std::min(begin + kBatch, at.count()));
}

/// Squared error of every pixel of the last look: the sum over RGB, [pixels].
void squares(const ScoringPass& pass, Buffer<float>& out) {
  const Buffer<float>& residual = pass.residual();
  out.resize(residual.size() / 3);
  for (const ViewArgs<float>& view : pass.views().views) {
    const int64_t pixels = int64_t(view.width) * view.height;
    const float *r = residual.data() + 3 * view.first_pixel, *g = r + pixels, *b = g + pixels;
    float* to = out.data() + view.first_pixel;
    parallel_for(pixels, kPixelGrain, [&](int64_t begin, int64_t end) {
      for (int64_t p = begin; p < end; ++p) to[p] = r[p] * r[p] + g[p] * g[p] + b[p] * b[p];
    });
  }
}

/// What the last look has more of than `before`, [pixels], in the first channel, [3·pixels] as
/// ScoringPass::sums takes it; zeros in the others.
void added_squares(const ScoringPass& pass, const Buffer<float>& before, Buffer<float>& now,
                   Buffer<float>& x) {
  squares(pass, now);
  x.resize(3 * now.size());
  for (const ViewArgs<float>& view : pass.views().views) {
    const int64_t pixels = int64_t(view.width) * view.height, first = view.first_pixel;
    float* to = x.data() + 3 * first;
    parallel_for(pixels, kPixelGrain, [&](int64_t begin, int64_t end) {
      for (int64_t p = begin; p < end; ++p) to[p] = now[first + p] - before[first + p];
      std::fill(to + pixels + begin, to + pixels + end, 0.0f);
      std::fill(to + 2 * pixels + begin, to + 2 * pixels + end, 0.0f);
    });
  }
}

/// What the model as it is leaves in every batch, as `squares` has it.
std::vector<Buffer<float>> squares_of(Backend& backend, const GaussianModel& model,
                                      const FrameSample& at) {
  std::vector<Buffer<float>> found;
  ScoringPass pass(backend, model);
  for_each_batch(at, [&](int64_t begin, int64_t end) {
    pass.draw(at, begin, end);
    squares(pass, found.emplace_back());
  });
  return found;
}

/// Squared error that a trial adds: in all, and each candidate's share by its light.
struct Added {
  std::vector<double> of;  // [candidates]
  double total = 0;
};

/// Candidates are the last rows of the trial's static set.
Added added_error(Backend& backend, const GaussianModel& trial, int64_t candidates,
                  const std::vector<Buffer<float>>& before, const FrameSample& at) {
  Added added;
  added.of.assign(size_t(candidates), 0);
  const int64_t first = trial.static_set.count() - candidates;
  ScoringPass pass(backend, trial);
  Buffer<float> now, x;
  for_each_batch(at, [&](int64_t begin, int64_t end) {
    pass.draw(at, begin, end);
    added_squares(pass, before[size_t(begin / kBatch)], now, x);
    std::vector<double> parts(size_t(x.size() / kPixelGrain + 1), 0.0);
    parallel_for(x.size(), kPixelGrain, [&](int64_t from, int64_t to) {
      parts[size_t(from / kPixelGrain)] = std::accumulate(x.begin() + from, x.begin() + to, 0.0);
    });
    added.total += std::accumulate(parts.begin(), parts.end(), 0.0);
    const ScoringPass::SplatSums& sums = pass.sums(std::as_const(x).span());
    parallel_for(candidates, kGaussianGrain, [&](int64_t from, int64_t to) {
      for (int64_t i = from; i < to; ++i)
        for (int64_t s = sums.first_of[first + i]; s < sums.first_of[first + i + 1]; ++s)
          added.of[size_t(i)] += double(sums.sum[s].image[0]);
    });
  });
  return added;
}

}  // namespace

GaussianSet as_static(const GaussianModel& model, const SetContributions& contributions) {
  const GaussianSpans<const float> from = model.dynamic_set.values();
  GaussianSet still(Form::kStatic, from.coefficients);
  still.resize(from.count);
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), from.coefficients, from.time_levels);
  for (int64_t n = 0; n < from.count; ++n) {
    const float timestep = contributions.mean_time[size_t(n)],
                opacity = contributions.opacity[size_t(n)];
    from.form == Form::kPair
        ? place_still<Form::kPair>(from, colours, n, timestep, opacity, still.values())
        : place_still<Form::kVelocity>(from, colours, n, timestep, opacity, still.values());
  }
  return still;
}

DemotionTrial try_demotion(Backend& backend, const GaussianModel& model,
                           const Contributions& contributions, const FrameSample& at,
                           double allowed, int rounds) {
  DemotionTrial trial;
  const SetContributions& of = contributions.sets[1];
  for (size_t n = 0; n < of.weight.size(); ++n)
    if (of.weight[n] > 0) trial.rows.push_back(int64_t(n));
  const GaussianSet still = as_static(model, of);
  const std::vector<Buffer<float>> before = squares_of(backend, model, at);
  for (int round = 0; round < rounds && !trial.rows.empty(); ++round) {
    const GaussianSet candidates = select_rows(still, trial.rows);
    const Added added =
        added_error(backend, tried(model, candidates, trial.rows), candidates.count(), before, at);
    trial.error = added.total;
    std::vector<std::pair<double, int64_t>> accepted;
    for (size_t i = 0; i < trial.rows.size(); ++i) {
      if (added.of[i] <= allowed) accepted.emplace_back(added.of[i], trial.rows[i]);
    }
    // what nobody in particular adds counts too: then only the better half is tried again
    const bool together = added.total <= allowed * double(trial.rows.size());
    const bool all = accepted.size() == trial.rows.size();
    if (all && together) break;
    if (all) {
      std::stable_sort(accepted.begin(), accepted.end());
      accepted.resize(accepted.size() / 2);
    }
    if (round + 1 == rounds && !together) accepted.clear();
    trial.rows.clear(), trial.error = 0;
    for (const auto& [error, row] : accepted) {
      trial.rows.push_back(row);
      trial.error += error;
    }
    std::sort(trial.rows.begin(), trial.rows.end());
  }
  trial.demoted = select_rows(still, trial.rows);
  return trial;
}

}  // namespace tessera
