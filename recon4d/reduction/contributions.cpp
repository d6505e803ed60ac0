// What: sums of splats per Gaussian, over batches of frames in the order of their timesteps.
// Not: the sums of a splat over its pixels (kernels/stages/sensitivity).
#include "recon4d/reduction/contributions.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/parallel.h"
#include "kernels/elements/load_gaussian.h"
#include "recon4d/evaluation/render.h"

namespace tessera {
namespace {

constexpr int64_t kBatch = 4;  // frames drawn at once

/// Of one Gaussian: what is left over it at one timestep, summed over cameras.
struct TimestepSums {
  Vec3<double> residual{}, light{};
  double weight2 = 0;
};

/// Sums over timesteps of what TimestepSums have: the error that a colour of its own at every
/// timestep takes away is Σ_t |s_t|²/W_t, that one colour for all of them does |Σ s_t|²/Σ W_t.
struct ChangeSums {
  TimestepSums now, all;
  double gain = 0;

  void close_timestep(double time, SetContributions::Change& change) {
    if (!(now.weight2 > 0)) return;
    const double here = dot(now.residual, now.residual) / now.weight2;
    gain += here;
    all.residual += now.residual, all.weight2 += now.weight2;
    change.timesteps += 1;
    change.light += float(dot(now.light, now.light) / now.weight2);
    if (here > double(change.peak_gain)) {
      change.peak_gain = float(here), change.peak_time = float(time);
      change.colour = Vec3<float>(now.residual * (-1 / now.weight2));
    }
    now = {};
  }
  void finish(SetContributions::Change& change) const {
    if (!(all.weight2 > 0)) return;
    change.gain = float(gain - dot(all.residual, all.residual) / all.weight2);
    // as long as if every timestep had the gain of the best
    change.lasting = change.peak_gain > 0 ? float(gain / double(change.peak_gain)) : 0;
  }
};

class Summing {
 public:
  Summing(const GaussianModel& model, Contributions& contributions)
      : model_(model), options_(render_options(model)), worth_(contributions) {
    for (int k = 0; k < 2; ++k) contributions.sets[k].resize(set(k).count());
    changes_.resize(size_t(model.static_set.count()));
  }

  /// Of the batch that `pass` has looked at.
  void add(ScoringPass& pass) {
    const ViewBatch<float>& views = pass.views();
    const ScoringPass::SplatSums& sums = pass.sums();
    const Buffer<Splat<float>>& splats = pass.splats();
    add_set<Form::kStatic>(0, 0, views, splats, sums);
    const int64_t first = model_.static_set.count();
    if (model_.dynamic_set.form() == Form::kPair)
      add_set<Form::kPair>(1, first, views, splats, sums);
    else
      add_set<Form::kVelocity>(1, first, views, splats, sums);
  }
  void close_timestep(double time) {
    for (size_t n = 0; n < changes_.size(); ++n)
      changes_[n].close_timestep(time, worth_.sets[0].change[n]);
  }
  void finish() {
    for (size_t n = 0; n < changes_.size(); ++n) changes_[n].finish(worth_.sets[0].change[n]);
    for (SetContributions& of : worth_.sets)
      for (size_t n = 0; n < of.weight.size(); ++n) {
        const float light = std::max(of.weight[n], 1e-12f);
        of.mean_time[n] /= light, of.opacity[n] /= light;
      }
  }

 private:
  const GaussianSet& set(int k) const { return k == 0 ? model_.static_set : model_.dynamic_set; }

  template <Form form>
  void add_set(int k, int64_t before, const ViewBatch<float>& views,
               const Buffer<Splat<float>>& splats, const ScoringPass::SplatSums& sums) {
    constexpr int64_t kGrain = 512;
    const GaussianSpans<const float> values = set(k).values();
    const ColourRules<float> colours =
        make_colour_rules<float>(options_, values.coefficients, values.time_levels);
    parallel_for(values.count, kGrain, [&](int64_t begin, int64_t end) {
      for (int64_t n = begin; n < end; ++n) {
        const int64_t first = sums.first_of[before + n], last = sums.first_of[before + n + 1];
        GaussianState<float> g;
        if (first == last || !load_gaussian<form>(values, n, g)) continue;
        for (int64_t s = first; s < last; ++s)
          add_splat(views, colours, g, splats[s], sums.sum[s], k, size_t(n));
      }
    });
  }

  void add_splat(const ViewBatch<float>& views, const ColourRules<float>& colours,
                 const GaussianState<float>& g, const Splat<float>& splat,
                 const SplatSensitivity<float>& sum, int k, size_t n) {
    if (!(sum.weight > 0)) return;
    SetContributions& of = worth_.sets[k];
    const ViewArgs<float>& view = views.views[size_t(splat.view)];
    of.weight[n] += sum.weight;
    of.removal1[n] += sum.removal1, of.removal2[n] += sum.removal2;
    of.mean_time[n] += sum.weight * view.time;
    of.opacity[n] += sum.weight * splat.opacity;
    add_truncation_errors(view, colours, g, splat, sum, of.truncation_error[n]);
    if (k == 1) return;
    changes_[n].now.residual += Vec3<double>(sum.image);
    changes_[n].now.light += Vec3<double>(splat.colour) * double(sum.weight);
    changes_[n].now.weight2 += double(sum.weight2);
  }

  /// Without the bands above d the colour is less by δ_d = Σ Y_k c_k, so that Σ (r − w δ)² grows by
  /// Σ w² |δ|² − 2 ⟨Σ w r, δ⟩.
  void add_truncation_errors(const ViewArgs<float>& view, const ColourRules<float>& colours,
                             const GaussianState<float>& g, const Splat<float>& splat,
                             const SplatSensitivity<float>& sum, std::array<float, 3>& cut) const {
    if (colours.degree == 0) return;
    const Slice<float> slice = slice_at(g.mean, g.spacetime, view.time, float(model_.time_filter));
    float distance;
    const Vec3<float> direction =
        view_direction(view, colours.sliced_direction ? slice.mean : g.mean, distance);
    float Y[kMaxShCoefficients] = {}, room[3 * kMaxShCoefficients];
    sh_basis(colours.degree, direction, Y);
    const float* const sh = sh_at(colours, g, slice.delta, room);
    Vec3<float> less(0.0f);
    for (int d = colours.degree - 1; d >= 0; --d) {
      for (int j = sh_coefficients(d); j < sh_coefficients(d + 1); ++j)
        less += Y[j] * load3(sh + 3 * j);
      Vec3<float> shown = less;  // a channel that is clamped does not change
      for (int c = 0; c < 3; ++c)
        if (splat.negative >> c & 1) shown[c] = 0;
      cut[size_t(d)] += sum.weight2 * dot(shown, shown) - 2 * dot(sum.image, shown);
    }
  }

  const GaussianModel& model_;
  const RenderOptions options_;
  Contributions& worth_;
  std::vector<ChangeSums> changes_;  // of the static set
};

int64_t counted_samples(const Frame& frame) {
  const std::vector<uint8_t>& mask = frame.mask.data;
  if (mask.empty()) return int64_t(frame.image.data.size());
  return 3 * int64_t(std::count_if(mask.begin(), mask.end(), [](uint8_t m) { return m != 0; }));
}

/// Mean square of gain − 1 over images and channels.
double gain_variance(const std::vector<Vec3<double>>& gains) {
  double sum = 0;
  for (const Vec3<double>& gain : gains) sum += dot(gain - 1.0, gain - 1.0) / 3;
  return gains.empty() ? 0 : sum / double(gains.size());
}

double sum_of_squares(const Buffer<float>& values) {
  constexpr int64_t kGrain = 1 << 16;
  std::vector<double> parts(size_t((values.size() + kGrain - 1) / kGrain), 0.0);
  parallel_for(values.size(), kGrain, [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t i = begin; i < end; ++i) sum += double(values[i]) * double(values[i]);
    parts[size_t(begin / kGrain)] = sum;
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return sum;
}

}  // namespace

void SetContributions::resize(int64_t count) {
  for (std::vector<float>* values : {&weight, &removal1, &removal2, &mean_time, &opacity})
    values->assign(size_t(count), 0.0f);
  truncation_error.assign(size_t(count), {});
  change.assign(size_t(count), {});
}

double Contributions::psnr_after(double added) const {
  return 10 *
         std::log10(double(std::max<int64_t>(1, samples)) / std::max(1e-12, squared_error + added));
}

Contributions measure_contributions(Backend& backend, const GaussianModel& model,
                                    const FrameSample& at) {
  Contributions contributions;
  contributions.gain_variance = gain_variance(at.gain);
  Summing summing(model, contributions);
  ScoringPass pass(backend, model);
  const auto time = [&](int64_t i) { return at.scene->frames[size_t(at.frames[size_t(i)])].time; };
  for (int64_t begin = 0; begin < at.count();) {
    int64_t end = begin + 1;  // a batch has one timestep
    while (end < std::min(begin + kBatch, at.count()) && time(end) == time(begin)) ++end;
    pass.draw(at, begin, end);
    contributions.squared_error += sum_of_squares(pass.residual());
    for (int64_t i = begin; i < end; ++i)
      contributions.samples += counted_samples(at.scene->frames[size_t(at.frames[size_t(i)])]);
    summing.add(pass);
    if (end == at.count() || time(end) != time(begin)) summing.close_timestep(time(begin));
    begin = end;
  }
  summing.finish();
  return contributions;
}

}  // namespace tessera
