// The order matters: validation views leave the training split before anything looks at it, and
// exposure is refused before motion is tried.
#include "tools/session/training_setup.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <exception>
#include <future>

#include "recon4d/model/clocks.h"
#include "recon4d/model/exposure.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/validation.h"
#include "tools/session/clock/session_events.h"

namespace tessera {
namespace {

using nlohmann::json;

/// config.json of the training that is resumed.
json provenance(const TrainingSetup& setup) {
  return json::parse(setup.previous->provenance);
}

/// A model within so many dB of the best needs frames by which that is told.
void complete_size_limit(TrainOptions& options, SessionObserver& observer) {
  constexpr double kShare = 0.1;
  if (options.within_db == 0 || options.validation_share > 0) return;
  options.validation_share = kShare;
  observer.on_message(fmt::format(
      "--within-db: a share of {} of the training frames become validation views", kShare));
}

void check_frames(const TrainingSetup& setup, const TrainRequest& request, const RunFolder& run) {
  if (provenance(setup).value("scene_fingerprint", "") !=
      setup.config["scene_fingerprint"].get<std::string>())
    throw CheckpointRefused(
        fmt::format("{}: was trained on other frames, cameras or points than {} holds; resume with "
                    "the scene it was started on",
                    run.checkpoint().string(), request.scene.string()));
}

/// Where the observer stops the trials, motion stays `auto` and the training takes no step.
void complete_motion(TrainingSetup& setup, const TrainRequest& request, double seconds,
                     SessionObserver& observer) {
  const double begin = request.stopwatch(), last = begin + seconds;
  const auto say = [&](const std::string& line) { observer.on_message(line); };
  const auto stop = [&] {
    setup.stopped = setup.stopped || observer.must_stop();
    return setup.stopped || request.stopwatch() > last;
  };
  const bool known =
      resolve_motion(*setup.backend, setup.scene, setup.with_nodes, setup.options, stop, say);
  setup.motion_seconds = request.stopwatch() - begin;
  if (known || setup.stopped) return;
  setup.options.motion = Motion::kPair;
  say("motion: dynamic Gaussians, as --time-limit leaves too little time to try nodes; "
      "--motion nodes does otherwise");
}

/// What follows from the images alone.
void complete_by_images(TrainingSetup& setup, const TrainRequest& request, double motion_seconds,
                        WallSplit& wall, SessionObserver& observer,
                        const std::function<void(const std::string&)>& warn) {
  Scene& scene = setup.scene;
  std::vector<std::string> warnings;
  const std::optional<std::string> cloud = wall.time(WallSplit::kCloud, [&] {
    return complete_cloud(
        scene, setup.options, request.window, [&] { return setup.backend->pixel_search(); },
        warnings);
  });
  if (cloud) observer.on_message(*cloud);
  for (const std::string& warning : warnings) warn(warning);
  for (const std::string& found : resolve_by_cloud(scene, setup.options))
    observer.on_message(found);
  if (setup.shared && setup.options.peak_gaussians > 0)  // the limit is of those beside it
    setup.options.peak_gaussians += setup.shared->model.static_set.count();
  // refuses what cannot be learned before motion is tried
  exposure_rows(scene, scene.split_indices(Split::kTrain), setup.options);
  clock_rows(scene, scene.split_indices(Split::kTrain), setup.options);
  wall.time(WallSplit::kTrial, [&] { complete_motion(setup, request, motion_seconds, observer); });
}

/// What the windows of a clip share. A resumed training has the static set and the options already.
void share_static(TrainingSetup& setup, const TrainRequest& request) {
  if (request.static_model.empty()) return;
  setup.shared = load_static_model(request.static_model);
  check_world(*setup.shared, setup.scene);
  if (!setup.previous) {
    adopt_rules(*setup.shared, setup.options);
    share_limits(*setup.shared, request.window ? request.window->count : 1, request.shipped_bytes,
                 setup.options);
  }
  adopt_light(setup.scene, *setup.shared, setup.options);
  setup.scene.stills = setup.shared->stills;
}

/// The device starts while the scene is read. What is wrong with the scene is said first.
void load_beside_device(TrainingSetup& setup, const TrainRequest& request, WallSplit& wall) {
  auto scene = std::async(std::launch::async, [&] {
    return load_training_scene(request.scene, setup.options, request.window,
                               request.evaluate_every != kNeverEvaluate);
  });
  std::exception_ptr failed;
  wall.time(WallSplit::kDevice, [&] {
    try {
      ChosenBackend chosen = choose_backend(request.backend);
      setup.backend = std::move(chosen.backend);
      setup.choice = std::move(chosen.choice);
    } catch (...) {
      failed = std::current_exception();
    }
  });
  wall.time(WallSplit::kLoad, [&] { setup.scene = scene.get(); });
  if (failed) std::rethrow_exception(failed);
}

/// The checkpoint's training goes on as one of so many steps would from there.
void go_on_until(int64_t iterations, const RunFolder& run, TrainingSetup& setup) {
  const std::string root = run.root.string();
  TrainState& state = setup.previous->state;
  if (iterations <= state.iteration)
    throw InputError(fmt::format("{}: is at step {}; --resume --iterations {} has no step left",
                                 root, state.iteration, iterations));
  if (state.finished && setup.options.filter_3d != Filter3d::kNone)
    throw InputError(fmt::format(
        "{}: is finished, and its 3D filter is part of the Gaussians now; train anew with "
        "--iterations {}",
        root, iterations));
  setup.options.iterations = iterations;
  state.finished = false;
}

}  // namespace

TrainingSetup previous_setup(const TrainRequest& request, const RunFolder& run,
                             SessionObserver& observer) {
  TrainingSetup setup;
  setup.previous = previous_state(request, run);
  setup.options = setup.previous ? setup.previous->options : request.options;
  if (!setup.previous)
    setup.with_nodes = request.with_nodes;
  else if (const json stored = provenance(setup); stored.contains("with_nodes"))
    setup.with_nodes = train_options_from_json(stored["with_nodes"]);
  if (setup.previous && request.more_iterations) go_on_until(*request.more_iterations, run, setup);
  complete_size_limit(setup.options, observer);
  validate(setup.options);
  return setup;
}

void complete_setup(TrainingSetup& setup, const TrainRequest& request, const RunFolder& run,
                    double seconds, WallSplit& wall, SessionObserver& observer,
                    const std::function<void(const std::string&)>& warn) {
  constexpr double kShareOfMotion = 0.25;
  TrainOptions& options = setup.options;
  load_beside_device(setup, request, wall);
  wall.time(WallSplit::kLoad, [&] { share_static(setup, request); });
  if (setup.shared && setup.shared->light != kSameLight)
    observer.on_message(fmt::format("light: {:.2f} of that of the background (red, green, blue)",
                                    fmt::join(setup.shared->light, ", ")));
  for (const std::string& warning : training_warnings(setup.scene, options)) warn(warning);
  setup.validation_views =
      hold_out_validation(setup.scene, options.validation_share, uint64_t(options.seed));
  wall.time(WallSplit::kInit, [&] {
    const std::string fingerprint = scene_fingerprint(setup.scene);
    if (setup.choice.leaves_cuda_unused()) observer.on_cuda_unused(setup.choice.reason);
    if (!setup.previous || options.motion == Motion::kAuto)
      complete_by_images(setup, request, kShareOfMotion * seconds, wall, observer, warn);
    if (const std::string line = readout_warning(setup.scene, options); !line.empty()) warn(line);
    setup.config =
        make_config(request, {options, setup.with_nodes}, setup.scene, setup.backend->name());
    setup.config["scene_fingerprint"] = fingerprint;
    if (setup.shared && setup.shared->light != kSameLight)
      setup.config["light"] = setup.shared->light;
    json& asked = setup.config["asked_options"] =
        setup.previous ? provenance(setup).value("asked_options", json())
                       : to_json(request.options);
    if (setup.previous && asked.is_object()) asked["iterations"] = options.iterations;
    if (!setup.previous) return;
    check_frames(setup, request, run);
    if (setup.previous->options.motion == Motion::kAuto) setup.previous.reset();
  });
}

}  // namespace tessera
