// What: one step after another.
// Not: equations, schedules or density rules: those have files of their own.
#include "recon4d/trainer.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/initialise.h"
#include "recon4d/render.h"

namespace tessera {
namespace {

std::vector<int> training_frames(const Scene& scene) {
  std::vector<int> frames = scene.split_indices(Split::kTrain);
  if (frames.empty())
    throw InputError(fmt::format("{}: no frame belongs to the training split", scene.path));
  return frames;
}

std::string group_names(unsigned bits, int dim) {
  std::string names;
  for (int g = 0; g < kGroupCount; ++g)
    if (bits >> g & 1)
      names += (names.empty() ? "" : ", ") + std::string(group_name(Group(g), dim));
  return names;
}

}  // namespace

TrainState initial_state(const Scene& scene, const TrainOptions& options, std::string& source) {
  training_frames(scene);
  TrainState state;
  Initialisation first = initialise_model(scene, make_camera_rig(scene), options);
  source = first.source;
  state.model = std::move(first.model);
  state.model.static_set.ensure_moments();
  state.model.dynamic_set.ensure_moments();
  state.statistics[0].reset(state.model.static_set.count());
  state.statistics[1].reset(state.model.dynamic_set.count());
  return state;
}

Trainer::Trainer(Backend& backend, const Scene& scene, const TrainOptions& options,
                 TrainState state, Observer& observer)
    : backend_(backend),
      scene_(scene),
      options_(options),
      state_(std::move(state)),
      observer_(observer),
      train_frames_(training_frames(scene)),
      rig_(make_camera_rig(scene)),
      schedule_(options, rig_.extent),
      sampler_(int64_t(train_frames_.size()), uint64_t(options.seed)),
      pipeline_(backend),
      gradients_{{3, state_.model.static_set.coefficients()},
                 {4, state_.model.dynamic_set.coefficients()}} {
  validate(options_);
  sampler_.restore(state_.sampler_epoch, state_.sampler_position);
  for (int i = 0; i < 2; ++i) set(i).ensure_moments();
}

void Trainer::run(int64_t iteration, const std::function<bool()>& stop) {
  const int64_t last = std::min(iteration, options_.iterations);
  while (state_.iteration < last) {
    if (stop && stop()) return;
    const auto begin = std::chrono::steady_clock::now();
    StepReport report = step();
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    state_.seconds += report.seconds;
    observer_.on_step(report);
  }
  if (state_.iteration >= options_.iterations && !state_.finished) finish();
}

int64_t Trainer::room_of(int k) const {
  if (options_.max_gaussians == 0) return -1;
  const GaussianModel& model = state_.model;
  const int64_t room = std::max<int64_t>(0, options_.max_gaussians - model.count());
  // the static set comes first and must leave the dynamic one its share
  return k == 1 || room == 0 ? room : room * model.static_set.count() / model.count();
}

void Trainer::control() {
  const int64_t i = state_.iteration;
  state_.model.sh_degree = schedule_.sh_degree(i);
  for (int k = 0; k < 2; ++k) {
    if (set(k).count() == 0) continue;
    if (schedule_.densify(i)) {
      const DensityReport report = control_density(
          backend_, {options_, rig_.extent, schedule_.prunes_large(i), room_of(k), uint64_t(i)},
          set(k), state_.statistics[k]);
      observer_.on_density(i, k == 0 ? "static" : "dynamic", report);
    }
    if (schedule_.reorder(i)) reorder(backend_, set(k), state_.statistics[k]);
    if (schedule_.reset_opacity(i)) reset_opacity(set(k));
  }
}

StepReport Trainer::step() {
  control();
  std::vector<View> views;
  Target target;
  target.weights = {1 - options_.lambda_dssim, options_.lambda_dssim};
  for (int64_t index : sampler_.next(options_.batch)) {
    const Frame& frame = scene_.frames[size_t(train_frames_[size_t(index)])];
    views.push_back({frame.camera, frame.time});
    target.truth.push_back({frame.image.data.data(), int64_t(frame.image.data.size())});
  }
  pipeline_.forward(std::as_const(state_.model.static_set).values(),
                    std::as_const(state_.model.dynamic_set).values(), views,
                    render_options(state_.model), true);
  const std::vector<ViewLoss> losses = pipeline_.loss(target, true);

  StepReport report;
  for (const ViewLoss& loss : losses) {
    report.loss += loss.total / double(losses.size());
    report.l1 += loss.l1 / double(losses.size());
    report.ssim += loss.ssim / double(losses.size());
  }
  const unsigned bad = backward();
  if (!std::isfinite(report.loss) || bad != 0)
    throw NumericalError(fmt::format(
        "step {}: {} not finite; the last checkpoint is intact; lower the learning rates or look "
        "for broken frames",
        state_.iteration + 1,
        bad == 0 ? "the loss is"
                 : "the gradient of " + group_names(bad, set(1).count() > 0 ? 4 : 3) + " is"));
  ++state_.iteration;
  state_.sampler_epoch = sampler_.epoch(), state_.sampler_position = sampler_.position();
  const PipelineReport counts = pipeline_.report();
  report.iteration = state_.iteration;
  report.num_static = state_.model.static_set.count();
  report.num_dynamic = state_.model.dynamic_set.count();
  report.splats = counts.splats, report.instances = counts.instances;
  report.invalid_gaussians = counts.invalid_gaussians;
  return report;
}

unsigned Trainer::backward() {
  const int64_t i = state_.iteration;
  BackwardArgs<float> args;
  for (int k = 0; k < 2; ++k) {
    SinkArgs<float>& sink = args.sinks[k];
    sink.fused = options_.fused_optimizer;
    sink.value = set(k).values(), sink.moment1 = set(k).moments1();
    sink.moment2 = set(k).moments2(), sink.adam = schedule_.adam(i, set(k).dim());
    if (!sink.fused) {
      gradients_[k].resize(set(k).count());
      sink.gradient = gradients_[k].values();
    }
    if (schedule_.gathers_statistics(i)) args.statistics[k] = state_.statistics[k].spans();
  }
  const unsigned bad = pipeline_.backward(args);
  if (!options_.fused_optimizer && bad == 0)
    for (const SinkArgs<float>& sink : args.sinks) backend_.adam(sink);
  return bad;
}

void Trainer::finish() {
  for (int k = 0; k < 2; ++k) {
    prune_invisible(backend_, set(k), state_.statistics[k]);
    reorder(backend_, set(k), state_.statistics[k]);
  }
  state_.finished = true;
}

}  // namespace tessera
