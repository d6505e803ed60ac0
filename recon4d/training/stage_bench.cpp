// A model of the requested size, and steps of the trainer on it.
#include "recon4d/training/stage_bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/base/errors.h"
#include "kernels/base/seconds_since.h"
#include "kernels/math/random.h"
#include "recon4d/density/density.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/initialise.h"
#include "recon4d/training/trainer.h"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

void check_options(const StageBenchOptions& bench) {
  if (bench.gaussians < 0) throw InputError("--gaussians is negative; 0 keeps the initial ones");
  if (!(bench.opacity > 0 && bench.opacity < 1))
    throw InputError("--opacity must be between 0 and 1, without both");
  if (bench.steps < 1 || bench.warm_up < 0)
    throw InputError("bench needs --steps of at least 1 and --warm-up of at least 0");
}

/// `set` repeated up to `count` rows, copies moved by about their own size; opacity as given.
GaussianSet enlarged(const GaussianSet& set, int64_t count, double opacity, uint64_t seed) {
  GaussianSet large = set.like();
  large.resize(count);
  const GaussianSpans<const float> from = set.values();
  const GaussianSpans<float> to = large.values();
  for (int64_t n = 0; n < count; ++n) {
    const int64_t source = n % set.count();
    for (int g = 0; g < set.groups(); ++g)
      std::copy_n(from.at(Group(g), source), set.width(Group(g)), to.at(Group(g), n));
    *to.at(kOpacityLogit, n) = float(std::log(opacity / (1 - opacity)));
    if (n < set.count()) continue;
    const Vec4<float> noise = normals(philox(seed, RandomStream::kSplit, uint64_t(n)));
    for (int k = 0; k < 3; ++k) to.at(kMean, n)[k] += noise[k] * std::exp(to.at(kLogScale, n)[k]);
  }
  return large;
}

GaussianModel initial_load(const Scene& scene, const TrainOptions& options,
                           const StageBenchOptions& bench) {
  GaussianModel model =
      initialise_model(scene, make_camera_rig(scene.training_cameras()), options).model;
  const int64_t before = model.count();
  if (before == 0) throw InputError("no initial Gaussians; raise --init-points");
  const int64_t wanted = bench.gaussians > 0 ? bench.gaussians : before;
  const int64_t statics = wanted * model.static_set.count() / before;
  const auto enlarge = [&](GaussianSet& set, int64_t count) {
    if (set.count() > 0) set = enlarged(set, count, bench.opacity, uint64_t(options.seed));
  };
  enlarge(model.static_set, statics);
  enlarge(model.dynamic_set, wanted - statics);
  model.drawing.sh_degree = int(options.sh_degree);
  model.drawing.sh_time_degree = int(options.sh_time_degree);
  return model;
}

/// Rows in an order that has nothing to do with where they lie.
void shuffle(GaussianSet& set, uint64_t seed) {
  std::vector<std::pair<uint32_t, int64_t>> keys;
  for (int64_t n = 0; n < set.count(); ++n)
    keys.emplace_back(philox(seed, RandomStream::kSampler, uint64_t(n)).word[0], n);
  std::sort(keys.begin(), keys.end());
  Buffer<int64_t> order(set.count());
  for (int64_t n = 0; n < set.count(); ++n) order[n] = keys[size_t(n)].second;
  const Span<const int64_t> rows = std::as_const(order).span();
  take_elements(*make_cpu_backend(), rows, rows, set);
}

/// Options of a training that leaves its load as it is: nothing is learnt, added or removed.
TrainOptions options_at_rest(TrainOptions options, int64_t steps) {
  constexpr int64_t kNever = 1000000000;
  options.iterations = options.schedule_iterations = steps;
  for (double* rate :
       {&options.lr_mean, &options.lr_mean_final, &options.lr_mean_time, &options.lr_scale,
        &options.lr_scale_time, &options.lr_rotation, &options.lr_velocity, &options.lr_opacity,
        &options.lr_sh, &options.lr_sh_rest, &options.lr_environment, &options.lr_exposure})
    *rate = 0;
  options.sh_interval = 1;
  options.densify_from = options.densify_until = kNever;  // statistics are gathered all the same
  options.opacity_reset_interval = 0;
  options.mcmc_noise = 0;
  return options;
}

/// The load before its first step. Its iteration is one by which all SH bands are in use and at
/// which a training would bring Gaussians into order.
TrainState load_of(const Scene& scene, const TrainOptions& options,
                   const StageBenchOptions& bench) {
  constexpr int64_t kAllBands = 100;
  const int64_t interval = std::max(options.reorder_interval, int64_t{1});
  TrainState state;
  state.model = bench.model ? bench.model->clone_values() : initial_load(scene, options, bench);
  state.iteration = (kAllBands + interval - 1) / interval * interval;
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    set.ensure_moments();
    state.statistics[k].reset(set.count());
    if (options.reorder_interval == 0) shuffle(set, uint64_t(options.seed));
  }
  return state;
}

/// Keeps the report of the last step.
class LastReport : public Observer {
 public:
  void on_step(const StepReport& report) override { last = report; }

  StepReport last;
};

}  // namespace

StageBenchReport bench_stages(Backend& backend, const Scene& scene, const TrainOptions& options,
                              const StageBenchOptions& bench) {
  check_options(bench);
  training_frames(scene);  // refuses a scene without
  TrainState load = load_of(scene, options, bench);
  const int64_t first = load.iteration + bench.warm_up;
  const int64_t last = first + bench.steps;
  LastReport reports;
  // one step more than are run, so that the model is not cleaned up
  Trainer trainer(backend, scene, options_at_rest(options, last + 1), std::move(load), reports);
  trainer.run(first);
  const std::array<StageTotals, kStages> before = backend.clock().totals();
  const Clock::time_point begin = Clock::now();
  trainer.run(last);
  const double steps = double(bench.steps);
  StageBenchReport report;
  report.step_seconds = seconds_since(begin) / steps;
  const std::array<StageTotals, kStages>& after = backend.clock().totals();
  for (size_t s = 0; s < kStages; ++s)
    report.stages[s] = {(after[s].seconds - before[s].seconds) / steps,
                        (after[s].bytes - before[s].bytes) / steps};
  report.gaussians = trainer.state().model.count();
  report.splats = reports.last.splats;
  report.instances = reports.last.instances;
  report.pixels = reports.last.pixels;
  report.peak_bytes = backend.memory().peak_bytes();
  return report;
}

double copy_bytes_per_second(Backend& backend) {
  constexpr int64_t kFloats = int64_t{1} << 26;  // 256 MiB, more than any cache
  constexpr int kCopies = 20;
  Buffer<float> from(kFloats, backend.memory());
  Buffer<float> to(kFloats, backend.memory());
  backend.fill_zero(from.span());
  const auto copy = [&] {
    backend.memory().copy(to.data(), from.data(), size_t(kFloats) * sizeof(float));
  };
  copy();
  double best = 1e30;
  for (int i = 0; i < kCopies; ++i) {
    const Clock::time_point begin = Clock::now();
    copy();
    best = std::min(best, seconds_since(begin));
  }
  return 2.0 * double(kFloats) * sizeof(float) / best;
}

}  // namespace tessera
