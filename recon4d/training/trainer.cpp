// The steps of a training in their order: density control, batch, forward pass, loss, backward
// pass.
#include "recon4d/training/trainer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/options/train_options.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/initialise.h"

namespace tessera {
namespace {

std::string group_names(unsigned bits, SetForm form) {
  std::string names;
  for (int g = 0; g < kGroupCount; ++g)
    if (bits >> g & 1)
      names += (names.empty() ? "" : ", ") + std::string(group_name(Group(g), form));
  return names;
}

/// "the loss", "the gradient of mean, environment".
std::string what_is_bad(const StepOutcome& outcome, SetForm form) {
  std::string names = group_names(outcome.bad_groups, form);
  if (outcome.bad_values) names += names.empty() ? "environment" : ", environment";
  return names.empty() ? "the loss" : "the gradient of " + names;
}

/// Moves nothing: what is subtracted from a value is 0.
AdamGroups<float> without_steps(AdamGroups<float> groups) {
  for (AdamScalars<float>& group : groups.group) group.step_size = 0;
  groups.sh_rest.step_size = 0;
  return groups;
}

/// Those that may see a set: every frame, or every camera once where times do not matter.
std::vector<View> filter_views(const Scene& scene, const std::vector<int>& frames, bool moving) {
  std::vector<View> views;
  std::map<std::array<double, 3>, std::vector<size_t>> views_by_position;
  for (const int i : frames) {
    const Frame& frame = scene.frames[size_t(i)];
    const glm::dvec3& t = frame.camera.translation;
    std::vector<size_t>& here = views_by_position[{t[0], t[1], t[2]}];
    if (!moving && std::any_of(here.begin(), here.end(),
                               [&](size_t v) { return views[v].camera == frame.camera; }))
      continue;
    here.push_back(views.size());
    views.push_back({frame.camera, frame.time});
  }
  return views;
}

}  // namespace

TrainState initial_state(const Scene& scene, const TrainOptions& options, std::string& source,
                         const GaussianSet* shared) {
  const std::vector<int> frames = training_frames(scene);
  TrainState state;
  state.exposure.reset(int64_t(exposure_rows(scene, frames, options).names.size()),
                       exposure_width(options.exposure));
  state.clocks.reset(int64_t(clock_rows(scene, frames, options).names.size()), kClockWidth);
  Initialisation first =
      initialise_model(scene, make_camera_rig(scene.training_cameras()), options, shared);
  source = first.source;
  state.static_is_frozen = shared != nullptr;
  state.model = std::move(first.model);
  if (options.environment) state.model.environment = first_environment(scene, options);
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
      rig_(make_camera_rig(scene.training_cameras())),
      schedule_(options, rig_.extent),
      sampler_(int64_t(train_frames_.size()), uint64_t(options.seed)),
      cache_(backend.memory(), scene, train_frames_, options.feed_bytes, options.batch,
             options.moving_weight > 0 || state_.static_is_frozen
                 ? moving_masks(scene, train_frames_)
                 : FrameMasks()),
      pipeline_(backend),
      gradients_{state_.model.static_set.like(backend.memory()),
                 state_.model.dynamic_set.like(backend.memory())},
      timesteps_(scene.timesteps_of(Split::kTrain)),
      d_nodes_(backend.memory()),
      d_environment_(backend.memory()),
      exposed_(exposure_rows(scene, train_frames_, options_)),
      clocked_(clock_rows(scene, train_frames_, options_)) {
  validate(options_);
  check(!state_.static_is_frozen ||
            (options_.filter_3d == Filter3d::kNone &&
             options_.densification != Densification::kMcmc && options_.motion != Motion::kNodes),
        "Trainer: options that change a static set beside its steps");
  const auto exposures = int64_t(exposed_.names.size());
  if (state_.exposure.rows() == 0)
    state_.exposure.reset(exposures, exposure_width(options_.exposure));
  check(state_.exposure.rows() == exposures, "Trainer: colours of other frames");
  check(exposures == 0 || state_.exposure.width() == exposure_width(options_.exposure),
        "Trainer: colours of another kind");
  maps_ = colour_maps_of(state_.exposure);
  const auto clocks = int64_t(clocked_.names.size());
  if (state_.clocks.rows() == 0) state_.clocks.reset(clocks, kClockWidth);
  check(state_.clocks.rows() == clocks, "Trainer: clocks of other cameras");
  clocks_ = clocks_of(state_.clocks, clocked_.frame);
  sampler_.restore(state_.sampler_epoch, state_.sampler_position);
  for (int k = 0; k < 2; ++k) state_.set(k).ensure_moments();
  if (options_.filter_3d != Filter3d::kNone)
    for (int k = 0; k < 2; ++k)
      filter_views_[k] = make_view_batch<float>(filter_views(scene, train_frames_, k == 1));
  if (&backend.memory() != &host_memory()) state_ = state_.clone_to(backend.memory());
}

void Trainer::run(int64_t iteration, const std::function<bool()>& stop) {
  const int64_t last = std::min(iteration, options_.iterations);
  reported_ = std::chrono::steady_clock::now();
  while (state_.iteration < last && !(stop && stop())) step();
  complete_pending();
  if (state_.iteration >= options_.iterations && !state_.finished) finish();
}

const TrainState& Trainer::host_state() {
  if (&backend_.memory() == &host_memory()) return state_;
  if (!host_state_) host_state_ = state_.clone_to(host_memory());
  return *host_state_;
}

const GaussianModel& Trainer::host_model() {
  const TrainState& state = host_state();
  if (!is_filtered(state, options_) && !state.has_blocks()) return state.model;
  if (!host_model_) host_model_ = baked_model(state, options_);
  return *host_model_;
}

const GaussianModel& Trainer::drawn_model() {
  return is_filtered(state_, options_) || state_.has_blocks() ? host_model() : state_.model;
}

void Trainer::release_step_buffers() {
  complete_pending();
  if (&backend_.memory() == &host_memory()) return;
  pipeline_.release();
  backend_.memory().trim();
}

void Trainer::apply(const StateEdit& edit) {
  complete_pending();
  forget_copies();
  pipeline_.release();
  state_.average.begin_anew();
  apply_edit(backend_, edit, state_);
  for (int k = 0; k < 2 && options_.filter_3d != Filter3d::kNone; ++k) measure_filter(k);
}

void Trainer::record(int64_t goal, double seconds) {
  state_.decided = state_.iteration;
  state_.goal = goal;
  state_.seconds += seconds;
  forget_copies();
}

FrameSample Trainer::sample_frames() {
  FrameSample sample = sample_training_frames(scene_);
  sample.kernels = kernel_switches(options_);
  std::vector<int64_t> indices;  // among the training frames, which are in ascending order
  for (const int frame : sample.frames)
    indices.push_back(std::lower_bound(train_frames_.begin(), train_frames_.end(), frame) -
                      train_frames_.begin());
  if (cache_.is_resident()) {
    TargetImages resident = cache_.truth(indices);
    sample.images = std::move(resident.images);
    sample.masks = std::move(resident.masks);
  }
  if (cache_.knows_motion())
    for (const int64_t i : indices) sample.moving.push_back(cache_.mask_on_host(i));
  sample.maps = maps(indices);
  for (const int64_t i : indices)
    if (!clocks_.empty()) sample.clocks.push_back(clock_of(i));
  return sample;
}

ForwardArgs<float> Trainer::forward_args() const {
  ForwardArgs<float> args{{drawn_values(state_, 0, options_), drawn_values(state_, 1, options_)},
                          {},
                          render_options(state_.model),
                          true};
  args.nodes = state_.model.nodes.spans();
  args.environment = environment_of(state_.model);
  args.options.kernels = kernel_switches(options_);
  return args;
}

void Trainer::step_nodes() {
  MotionNodes& nodes = state_.model.nodes;
  if (nodes.empty()) return;
  const auto adam = schedule_.node_adam(state_.iteration, nodes.refitted);
  for (size_t g = 0; g < adam.size(); ++g) {
    ParameterGroup& group = *nodes.groups()[g];
    backend_.adam_values(std::as_const(d_nodes_.groups()[g]->value).span(), adam[g],
                         group.value.span(), group.moment1.span(), group.moment2.span());
  }
}

void Trainer::step() {
  forget_copies();
  control();
  if (!clocks_.empty()) complete_pending();  // the views have the times of that step
  const std::vector<int64_t> batch = sampler_.next(options_.batch);
  ForwardArgs<float> args = forward_args();
  for (const int64_t index : batch) {
    const Frame& frame = scene_.frames[size_t(train_frames_[size_t(index)])];
    args.views.push_back(at_clock({frame.camera, frame.time}, clock_of(index)));
  }
  pipeline_.forward(args);
  complete_pending();  // the forward pass has waited for that step

  const PipelineReport counts = pipeline_.report();
  StepReport report;
  report.iteration = state_.iteration + 1;
  report.num_static = state_.model.static_set.count();
  report.num_dynamic = state_.model.dynamic_set.count();
  report.splats = counts.splats;
  report.instances = counts.instances;
  report.pixels = pipeline_.batch().pixels;
  report.invalid_gaussians = counts.invalid_gaussians;
  report.peak_bytes = backend_.memory().peak_bytes();
  const TargetImages fed = cache_.truth(batch);
  pipeline_.loss({fed.images,
                  {1 - options_.lambda_dssim, options_.lambda_dssim, 1 + options_.moving_weight,
                   options_.noise / 255},
                  fed.masks,
                  maps(batch)},
                 true);
  backward();
  prefetch();
  if (schedule_.averages(state_.iteration)) add_to_average(backend_, state_);
  ++state_.iteration;
  state_.sampler_epoch = sampler_.epoch();
  state_.sampler_position = sampler_.position();
  pending_ = report;
  pending_batch_ = batch;
}

std::vector<ColourMap<double>> Trainer::maps(const std::vector<int64_t>& batch) const {
  std::vector<ColourMap<double>> maps;
  for (const int64_t index : batch)
    if (!maps_.empty()) maps.push_back(maps_[size_t(exposed_.of_frame[size_t(index)])]);
  return maps;
}

CameraClock Trainer::clock_of(int64_t index) const {
  return clocks_.empty() ? CameraClock() : clocks_[size_t(clocked_.of_frame[size_t(index)])];
}

void Trainer::step_rows(const StepOutcome& outcome, int64_t i) {
  std::vector<int32_t> colours, clocks;
  for (const int64_t index : pending_batch_) {
    if (!maps_.empty()) colours.push_back(exposed_.of_frame[size_t(index)]);
    if (!clocks_.empty()) clocks.push_back(clocked_.of_frame[size_t(index)]);
  }
  if (!colours.empty() && !state_.static_is_frozen) {
    step_exposure(colours, outcome.d_maps, schedule_.exposure_rate(i), state_.exposure);
    maps_ = colour_maps_of(state_.exposure);
  }
  if (clocks.empty()) return;
  std::vector<CameraClock> gradients;
  for (size_t b = 0; b < outcome.d_times.size(); ++b)
    gradients.push_back({outcome.d_times[b], outcome.d_readouts[b]});
  step_clocks(clocks, gradients, clocked_, schedule_.clock_rate(i), state_.clocks);
  clocks_ = clocks_of(state_.clocks, clocked_.frame);
}

void Trainer::backward() {
  const int64_t i = state_.iteration;
  BackwardArgs<float> args;
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state_.set(k);
    SinkArgs<float>& sink = args.sinks[k];
    sink.fused = options_.fused_optimizer;
    sink.value = set.values();
    sink.moment1 = set.moments1();
    sink.moment2 = set.moments2();
    sink.adam = schedule_.adam(i, set.form(), state_.model.nodes.started);
    if (!state_.trains(k)) sink.adam = without_steps(sink.adam);
    sink.idle = options_.idle_updates;
    if (!sink.fused) {
      gradients_[k].resize(set.count(), set.blocks());
      sink.gradient = gradients_[k].values();
    }
    if (schedule_.gathers_statistics(i) && state_.trains(k)) {
      args.statistics[k] = state_.statistics[k].spans();
      args.statistics[k].length_share = length_share(options_, set.form());
    }
  }
  args.by_time = !clocks_.empty();
  args.regulariser = {options_.opacity_weight, options_.scale_weight};
  ParameterGroup& environment = state_.model.environment.map;
  d_environment_.resize(environment.value.size());
  args.d_environment = d_environment_.span();
  args.d_nodes = d_nodes_.spans();
  if (const MotionNodes& nodes = state_.model.nodes; !nodes.empty()) {
    constexpr double kKnots = 25;  // at which the weight is as it is stated
    args.acceleration =
        float(options_.node_acceleration * std::pow(nodes.knots / kKnots, 3) / double(nodes.count));
  }
  pipeline_.backward(args);
  const StageTimer timer(backend_.clock(), kUpdate);
  step_nodes();
  if (!environment.value.empty())
    backend_.adam_values(
        std::as_const(d_environment_).span(), adam_scalars<float>(options_.lr_environment, i + 1),
        environment.value.span(), environment.moment1.span(), environment.moment2.span());
  if (!options_.fused_optimizer)
    for (const SinkArgs<float>& sink : args.sinks) backend_.adam(sink);
  if (options_.filter_3d == Filter3d::kClamp)
    for (int k = 0; k < 2; ++k)
      backend_.edit_by_filter(FilterEdit::kRaiseScales, state_.filtered_values(k), 0);
  const double noise = schedule_.noise_scale(i);
  for (int k = 0; k < 2 && noise > 0; ++k)
    backend_.add_position_noise(state_.set(k).values(), {noise, uint64_t(options_.seed), i});
}

void Trainer::prefetch() {
  std::vector<std::vector<int64_t>> upcoming;
  for (int64_t skip = 0; skip < cache_.ahead(); ++skip)
    upcoming.push_back(sampler_.peek(skip, options_.batch));
  if (!upcoming.empty()) cache_.prefetch(upcoming);
}

void Trainer::complete_pending() {
  if (!pending_) return;
  StepReport report = *std::exchange(pending_, std::nullopt);
  const StepOutcome outcome = pipeline_.outcome();
  for (const ViewLoss& loss : outcome.losses) {
    report.loss += loss.total / double(outcome.losses.size());
    report.l1 += loss.l1 / double(outcome.losses.size());
    report.ssim += loss.ssim / double(outcome.losses.size());
  }
  const unsigned bad = outcome.bad_groups;
  if (!std::isfinite(report.loss) || bad != 0 || outcome.bad_values) {
    state_.iteration = report.iteration - 1;
    throw NumericalError(fmt::format(
        "step {}: {} not finite; the last checkpoint is intact; lower the learning rates or look "
        "for broken frames",
        report.iteration,
        what_is_bad(outcome, state_.set(report.num_dynamic > 0 ? 1 : 0).form()) + " is"));
  }
  step_rows(outcome, report.iteration - 1);
  const auto now = std::chrono::steady_clock::now();
  report.seconds = std::chrono::duration<double>(now - std::exchange(reported_, now)).count();
  state_.seconds += report.seconds;
  observer_.on_step(report);
}

void Trainer::finish() {
  forget_copies();
  take_average(state_);
  prune_free_space();
  const bool filtered = is_filtered(state_, options_);
  for (int k = 0; k < 2; ++k) {
    if (!state_.trains(k)) continue;
    if (filtered) backend_.edit_by_filter(FilterEdit::kBake, state_.filtered_values(k), 0);
    prune_invisible(backend_, state_.set(k), state_.statistics[k],
                    state_.model.cutoff<double>().least_alpha);
    reorder(backend_, state_.set(k), state_.statistics[k]);
  }
  state_.finished = true;
}

}  // namespace tessera
