// What: a model with candidates turned static beside the model as it is, picture by picture.
// Not: sums over pixels (kernels/stages/sensitivity).
#include "recon4d/stillness.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/base/parallel.h"
#include "kernels/math/splat.h"
#include "recon4d/hygiene.h"
#include "recon4d/render.h"
#include "recon4d/set_rows.h"
#include "recon4d/shape3.h"

namespace tessera {
namespace {

constexpr int64_t kPixelGrain = 1 << 15, kGaussianGrain = 2048;  // per task

template <Form form>
void place_still(const GaussianSpans<const float>& from, const ColourRules<float>& colours,
                 int64_t n, float moment, float opacity, const GaussianSpans<float>& to) {
  std::copy_n(from.at(kMean, n), 3, to.at(kMean, n));
  std::copy_n(from.at(kLogScale, n), 3, to.at(kLogScale, n));
  std::copy_n(from.at(kRotation, n), 4, to.at(kRotation, n));
  std::copy_n(from.at(kSh, n), from.width(kSh), to.at(kSh, n));
  *to.at(kOpacityLogit, n) = *from.at(kOpacityLogit, n);
  GaussianState<float> g;
  if (!(opacity > 0) || !load_gaussian<form>(from, n, g)) return;
  const Slice<float> slice = slice_at(g.mean, g.spacetime, moment);
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
  std::vector<char> gone(size_t(model.dynamic_set.count()), 0);
  for (const int64_t n : without) gone[size_t(n)] = 1;
  std::vector<int64_t> left;
  for (int64_t n = 0; n < model.dynamic_set.count(); ++n)
    if (!gone[size_t(n)]) left.push_back(n);
  trial.dynamic_set = select_rows(model.dynamic_set, left);
  return trial;
}

/// Error that the trial adds: in all, and the share of each candidate by its light in either model.
struct Added {
  std::vector<double> as_still, as_dynamic;  // [candidates]
  double total = 0;
};

/// Squares of `trial` less those of `base`, summed over RGB, in the first channel; zeros elsewhere.
void difference(const ViewBatch<float>& views, const Buffer<float>& base,
                const Buffer<float>& trial, Buffer<float>& out) {
  out.resize(base.size());
  std::fill(out.begin(), out.end(), 0.0f);
  for (const ViewArgs<float>& view : views.views) {
    const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
    parallel_for(pixels, kPixelGrain, [&](int64_t begin, int64_t end) {
      for (int c = 0; c < 3; ++c)
        for (int64_t p = begin; p < end; ++p) {
          const float before = base[first + c * pixels + p], then = trial[first + c * pixels + p];
          out[first + p] += then * then - before * before;
        }
    });
  }
}

double sum_of(const Buffer<float>& values) {
  std::vector<double> parts(size_t(values.size() / kPixelGrain + 1), 0.0);
  parallel_for(values.size(), kPixelGrain, [&](int64_t begin, int64_t end) {
    parts[size_t(begin / kPixelGrain)] =
        std::accumulate(values.begin() + begin, values.begin() + end, 0.0);
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

Added added_error(Backend& backend, const GaussianModel& model, const GaussianModel& trial,
                  const std::vector<int64_t>& candidates, const LookedAt& at) {
  constexpr int64_t kBatch = 4;
  Added added;
  added.as_still.assign(candidates.size(), 0), added.as_dynamic.assign(candidates.size(), 0);
  ResidualPass base(backend, model), other(backend, trial);
  Buffer<float> x;
  const auto gather = [&](const ResidualPass::SplatSums& sums, size_t i, int64_t n,
                          std::vector<double>& to) {
    for (int64_t s = sums.first_of[n]; s < sums.first_of[n + 1]; ++s)
      to[i] += double(sums.sum[s].picture[0]);
  };
  for (int64_t begin = 0; begin < at.count(); begin += kBatch) {
    const int64_t end = std::min(begin + kBatch, at.count());
    base.look(at, begin, end), other.look(at, begin, end);
    difference(base.views(), base.residual(), other.residual(), x);
    added.total += sum_of(x);
    const Span<const float> picture = std::as_const(x).span();
    const ResidualPass::SplatSums& now = base.sums(picture);
    const ResidualPass::SplatSums& then = other.sums(picture);
    const int64_t before = model.static_set.count();
    parallel_for(int64_t(candidates.size()), kGaussianGrain, [&](int64_t first, int64_t last) {
      for (int64_t i = first; i < last; ++i) {
        gather(now, size_t(i), before + candidates[size_t(i)], added.as_dynamic);
        gather(then, size_t(i), before + i, added.as_still);
      }
    });
  }
  return added;
}

}  // namespace

GaussianSet still_form(const GaussianModel& model, const SetWorth& worth) {
  const GaussianSpans<const float> from = model.dynamic_set.values();
  GaussianSet still(Form::kStatic, from.coefficients);
  still.resize(from.count);
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), from.coefficients, from.time_levels);
  for (int64_t n = 0; n < from.count; ++n) {
    const float moment = worth.moment[size_t(n)], opacity = worth.opacity[size_t(n)];
    from.form == Form::kPair
        ? place_still<Form::kPair>(from, colours, n, moment, opacity, still.values())
        : place_still<Form::kVelocity>(from, colours, n, moment, opacity, still.values());
  }
  return still;
}

StillTrial try_still(Backend& backend, const GaussianModel& model, const Worth& worth,
                     const LookedAt& at, double allowed) {
  constexpr int kRounds = 4;
  StillTrial trial;
  const SetWorth& of = worth.sets[1];
  for (size_t n = 0; n < of.weight.size(); ++n)
    if (of.weight[n] > 0) trial.rows.push_back(int64_t(n));
  const GaussianSet still = still_form(model, of);
  for (int round = 0; round < kRounds && !trial.rows.empty(); ++round) {
    const GaussianSet candidates = select_rows(still, trial.rows);
    const Added added =
        added_error(backend, model, tried(model, candidates, trial.rows), trial.rows, at);
    trial.error = added.total;
    std::vector<std::pair<double, int64_t>> accepted;
    for (size_t i = 0; i < trial.rows.size(); ++i) {
      const double error = std::max(added.as_still[i], added.as_dynamic[i]);
      if (error <= allowed) accepted.emplace_back(error, trial.rows[i]);
    }
    // what nobody in particular adds counts too: then only the better half is tried again
    const bool together = added.total <= allowed * double(trial.rows.size());
    const bool all = accepted.size() == trial.rows.size();
    if (all && together) break;
    if (all) {
      std::stable_sort(accepted.begin(), accepted.end());
      accepted.resize(accepted.size() / 2);
    }
    if (round + 1 == kRounds && !together) accepted.clear();
    trial.rows.clear();
    for (const auto& [error, row] : accepted) trial.rows.push_back(row);
    std::sort(trial.rows.begin(), trial.rows.end());
  }
  if (trial.rows.empty()) trial.error = 0;
  trial.still = select_rows(still, trial.rows);
  return trial;
}

}  // namespace tessera
