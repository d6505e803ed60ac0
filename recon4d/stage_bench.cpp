// What: a model of the wanted size, and steps of it.
// Not: the clock: the backend's own.
#include "recon4d/stage_bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/math/random.h"
#include "kernels/pipeline.h"
#include "recon4d/initialise.h"
#include "recon4d/kernel_options.h"
#include "recon4d/render.h"
#include "recon4d/train_state.h"

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
  GaussianSet large(set.dim(), set.coefficients());
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

GaussianModel make_load(const Scene& scene, const CameraRig& rig, const TrainOptions& options,
                        const StageBenchOptions& bench) {
  GaussianModel model = initialise_model(scene, rig, options).model;
  const int64_t before = model.count();
  if (before == 0) throw InputError("no initial Gaussians; raise --init-points");
  const int64_t wanted = bench.gaussians > 0 ? bench.gaussians : before;
  const int64_t dynamic = wanted * model.dynamic_set.count() / before;
  const int64_t counts[2] = {wanted - dynamic, dynamic};  // in the proportion of the initial ones
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = k == 0 ? model.static_set : model.dynamic_set;
    if (set.count() == 0) continue;
    set = enlarged(set, counts[k], bench.opacity, uint64_t(options.seed));
    set.ensure_moments();
  }
  model.sh_degree = int(options.sh_degree);
  return model;
}

/// Training frames in turn.
struct Views {
  std::vector<View> views;
  Target target;
  std::vector<Buffer<uint8_t>> truth;

  Views(Backend& backend, const Scene& scene, const TrainOptions& options) {
    const std::vector<int> frames = scene.split_indices(Split::kTrain);
    if (frames.empty()) throw InputError(scene.path + ": no frame belongs to the training split");
    for (int64_t b = 0; b < options.batch; ++b) {
      const Frame& frame = scene.frames[size_t(frames[size_t(b) % frames.size()])];
      views.push_back({frame.camera, frame.time});
      const int64_t bytes = int64_t(frame.image.data.size());
      truth.emplace_back(bytes, backend.memory());
      backend.memory().copy(truth.back().data(), frame.image.data.data(), size_t(bytes));
      target.truth.push_back(truth.back().span());
    }
    target.weights = {1 - options.lambda_dssim, options.lambda_dssim};
  }
};

}  // namespace

StageBenchReport bench_stages(Backend& backend, const Scene& scene, const TrainOptions& options,
                              const StageBenchOptions& bench) {
  check_options(bench);
  const CameraRig rig = make_camera_rig(scene);
  TrainState state;
  state.model = make_load(scene, rig, options, bench);
  for (int k = 0; k < 2; ++k) state.statistics[k].reset(state.set(k).count());
  state = state.clone_to(backend.memory());
  const Views batch(backend, scene, options);
  RenderOptions render = render_options(state.model);
  render.kernels = kernel_switches(options);

  Pipeline<float> pipeline(backend);
  StageBenchReport report;
  const auto step = [&] {
    pipeline.forward({{std::as_const(state.model.static_set).values(),
                       std::as_const(state.model.dynamic_set).values()},
                      batch.views,
                      render,
                      {},
                      true});
    pipeline.loss(batch.target, true);
    BackwardArgs<float> args;
    for (int k = 0; k < 2; ++k) {
      GaussianSet& set = state.set(k);
      SinkArgs<float>& sink = args.sinks[k];
      sink.fused = true, sink.value = set.values();
      sink.moment1 = set.moments1(), sink.moment2 = set.moments2();
      for (AdamScalars<float>& scalars : sink.adam.group) scalars = adam_scalars<float>(0, 1);
      sink.adam.sh_rest = adam_scalars<float>(0, 1);
      args.statistics[k] = state.statistics[k].spans();
    }
    pipeline.backward(args);
  };
  for (int64_t i = 0; i < bench.warm_up; ++i) step();
  pipeline.outcome();
  const std::array<StageTotals, kStages> before = backend.clock().totals();
  const Clock::time_point begin = Clock::now();
  for (int64_t i = 0; i < bench.steps; ++i) step();
  pipeline.outcome();
  const double steps = double(bench.steps);
  report.step_seconds = seconds_since(begin) / steps;
  const std::array<StageTotals, kStages>& after = backend.clock().totals();
  for (size_t s = 0; s < kStages; ++s)
    report.stages[s] = {(after[s].seconds - before[s].seconds) / steps,
                        (after[s].bytes - before[s].bytes) / steps};
  report.gaussians = state.model.count();
  report.splats = pipeline.report().splats, report.instances = pipeline.report().instances;
  report.pixels = pipeline.batch().pixels;
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
