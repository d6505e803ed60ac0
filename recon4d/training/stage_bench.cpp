// What: a model of the wanted size, and steps of it.
// Not: the clock: the backend's own.
#include "recon4d/training/stage_bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/lazy_schedule.h"
#include "kernels/math/random.h"
#include "kernels/pipeline.h"
#include "recon4d/density/density.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/train_state.h"
#include "recon4d/options/kernel_options.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/initialise.h"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

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
  model.sh_degree = int(options.sh_degree), model.sh_time_degree = int(options.sh_time_degree);
  return model;
}

/// Rows in an order that has nothing to do with where they lie.
void shuffle(Backend& backend, GaussianSet& set, uint64_t seed) {
  std::vector<std::pair<uint32_t, int64_t>> keys;
  for (int64_t n = 0; n < set.count(); ++n)
    keys.emplace_back(philox(seed, RandomStream::kSampler, uint64_t(n)).word[0], n);
  std::sort(keys.begin(), keys.end());
  Buffer<int64_t> host(set.count()), order(set.count(), backend.memory());
  for (int64_t n = 0; n < set.count(); ++n) host[n] = keys[size_t(n)].second;
  order.copy_from(host);
  for (int g = 0; g < set.groups(); ++g) {
    const int width = set.width(Group(g));
    Buffer<float>& values = set.group(Group(g)).value;
    Buffer<float> to(set.count() * width, backend.memory());
    backend.gather_rows(std::as_const(values).span(), std::as_const(order).span(), width,
                        set.count(), to.span());
    values = std::move(to);
  }
}

/// A step after another over the training views.
class Load {
 public:
  Load(Backend& backend, const Scene& scene, const TrainOptions& options,
       const StageBenchOptions& bench)
      : backend_(backend),
        scene_(scene),
        options_(options),
        frames_(training_frames(scene)),
        cache_(backend.memory(), scene, frames_, 0, options.batch),
        pipeline_(backend),
        gradients_{{Form::kStatic, 1}, {Form::kPair, 1}},
        table_(backend.memory()),
        d_environment_(backend.memory()) {
    state_.model = bench.model ? bench.model->clone_values() : initial_load(scene, options, bench);
    for (int k = 0; k < 2; ++k) {
      state_.set(k).ensure_moments();
      state_.statistics[k].reset(state_.set(k).count());
    }
    state_ = state_.clone_to(backend.memory());
    for (int k = 0; k < 2; ++k) arrange(k);
    const std::vector<double> table = lazy_adam_table(bench.warm_up + bench.steps + 1);
    table_.resize(int64_t(table.size()));
    backend.memory().copy(table_.data(), table.data(), table.size() * sizeof(double));
  }

  void step() {
    std::vector<int64_t> chosen;
    ForwardArgs<float> forward;
    for (int64_t b = 0; b < options_.batch; ++b) {
      chosen.push_back((state_.iteration * options_.batch + b) % int64_t(frames_.size()));
      const Frame& frame = scene_.frames[size_t(frames_[size_t(chosen.back())])];
      forward.views.push_back({frame.camera, frame.time});
    }
    forward.options = render_options(state_.model);
    forward.options.kernels = kernel_switches(options_);
    forward.for_backward = true;
    forward.environment = environment_of(std::as_const(state_).model);
    for (int k = 0; k < 2; ++k) {
      forward.sets[k] = std::as_const(state_).set(k).values();
      forward.lazy[k] = lazy(k);
    }
    pipeline_.forward(forward);
    const TargetImages fed = cache_.truth(chosen);
    pipeline_.loss({fed.images, {1 - options_.lambda_dssim, options_.lambda_dssim}, fed.masks},
                   true);
    backward();
    ++state_.iteration;
  }

  const TrainState& state() const { return state_; }
  Pipeline<float>& pipeline() { return pipeline_; }

 private:
  /// Order of the rows, room for gradients.
  void arrange(int k) {
    GaussianSet& set = state_.set(k);
    if (set.count() == 0) return;
    if (options_.reorder_interval > 0)
      reorder(backend_, set, state_.statistics[k]);
    else
      shuffle(backend_, set, uint64_t(options_.seed));
    gradients_[k] = set.like(backend_.memory());
    if (!options_.fused_optimizer) gradients_[k].resize(set.count());
  }

  LazySh<float> lazy(int k) { return lazy_sh(state_, k, options_, std::as_const(table_).span()); }

  void backward() {
    BackwardArgs<float> args;
    for (int k = 0; k < 2; ++k) {
      GaussianSet& set = state_.set(k);
      SinkArgs<float>& sink = args.sinks[k];
      sink.fused = options_.fused_optimizer, sink.value = set.values();
      sink.moment1 = set.moments1(), sink.moment2 = set.moments2();
      sink.gradient = gradients_[k].values();
      sink.idle = idle_update(options_), sink.lazy = lazy(k);
      for (AdamScalars<float>& scalars : sink.adam.group) scalars = adam_scalars<float>(0, 1);
      sink.adam.sh_rest = adam_scalars<float>(0, 1);
      args.statistics[k] = state_.statistics[k].spans();
    }
    d_environment_.resize(state_.model.environment.map.value.size());
    args.d_environment = d_environment_.span();
    pipeline_.backward(args);
    if (options_.fused_optimizer) return;
    const StageTimer timer(backend_.clock(), kUpdate);
    for (const SinkArgs<float>& sink : args.sinks) backend_.adam(sink);
  }

  Backend& backend_;
  const Scene& scene_;
  const TrainOptions& options_;
  std::vector<int> frames_;
  FrameCache cache_;
  TrainState state_;
  Pipeline<float> pipeline_;
  GaussianSet gradients_[2];  // only with a separate optimizer
  Buffer<double> table_;
  Buffer<float> d_environment_;
};

}  // namespace

StageBenchReport bench_stages(Backend& backend, const Scene& scene, const TrainOptions& options,
                              const StageBenchOptions& bench) {
  check_options(bench);
  Load load(backend, scene, options, bench);
  for (int64_t i = 0; i < bench.warm_up; ++i) load.step();
  load.pipeline().outcome();
  const std::array<StageTotals, kStages> before = backend.clock().totals();
  const Clock::time_point begin = Clock::now();
  for (int64_t i = 0; i < bench.steps; ++i) load.step();
  load.pipeline().outcome();
  const double steps = double(std::max<int64_t>(1, bench.steps));
  StageBenchReport report;
  report.step_seconds = seconds_since(begin) / steps;
  const std::array<StageTotals, kStages>& after = backend.clock().totals();
  for (size_t s = 0; s < kStages; ++s)
    report.stages[s] = {(after[s].seconds - before[s].seconds) / steps,
                        (after[s].bytes - before[s].bytes) / steps};
  const PipelineReport counts = load.pipeline().report();
  report.gaussians = load.state().model.count();
  report.splats = counts.splats, report.instances = counts.instances;
  report.pixels = load.pipeline().batch().pixels;
  report.peak_bytes = backend.memory().peak_bytes();
  return report;
}

double copy_bytes_per_second(Backend& backend) {
  constexpr int64_t kFloats = int64_t{1} << 26;  // 256 MiB, more than any cache
  constexpr int kCopies = 20;
  Buffer<float> from(kFloats, backend.memory()), to(kFloats, backend.memory());
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
