// Loads the scene with the options of a training, reads the checkpoint to resume, and makes
// config.json.
#include "tools/session/train_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/checks/cloud_health.h"
#include "ingest/checks/colour_gains.h"
#include "ingest/cloud/initial_cloud.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/images/image_noise.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "recon4d/motion/nodes.h"
#include "recon4d/options/forecast.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/motion_trial.h"
#include "recon4d/training/scene_scale.h"
#include "recon4d/training/shown_pixels.h"
#include "tools/session/device_choice.h"
#include "tools/session/static_model.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

using nlohmann::json;

template <class T>
void add_values(const std::vector<T>& values, Fnv1a& hash) {
  hash.add(values.data(), sizeof(T) * values.size());
}

/// One byte of a thousand: another image differs in many.
void add_sampled(const std::vector<uint8_t>& bytes, Fnv1a& hash) {
  constexpr size_t kApart = 1009;
  for (size_t i = 0; i < bytes.size(); i += kApart) hash.add(&bytes[i], 1);
}

/// Whether the frames in memory are those of the files, on black.
bool is_as_filed(const Scene& scene, const TrainOptions& options) {
  const bool on_black = scene.background == std::array<uint8_t, 3>{0, 0, 0};
  return options.train_scale == 1 && (on_black || !scene.had_alpha);
}

}  // namespace

std::string scene_fingerprint(const Scene& scene) {
  Fnv1a hash;
  for (const Frame& frame : scene.frames) {
    const Camera& camera = frame.camera;
    hash.add(
        fmt::format("{} {} {} {};", frame.name, frame.time, frame.image.width, frame.image.height));
    for (const double value : {camera.fl_x, camera.fl_y, camera.cx, camera.cy})
      hash.add(&value, sizeof(value));
    if (camera.readout != 0) hash.add(&camera.readout, sizeof(camera.readout));
    hash.add(&camera.cam_from_world, sizeof(camera.cam_from_world));
    hash.add(&camera.translation, sizeof(camera.translation));
    if (frame.split == Split::kTrain || frame.split == Split::kValidation)
      add_sampled(frame.image.data, hash);
    hash.add(frame.mask.data().data(), frame.mask.data().size());
  }
  add_values(scene.points.position, hash);
  add_values(scene.points.colour, hash);
  add_values(scene.points.time, hash);
  add_values(scene.points.velocity, hash);
  return hash.hex();
}

std::optional<Checkpoint> previous_state(const TrainRequest& request, const RunFolder& run) {
  const std::string root = run.root.string();
  if (!request.resume) {
    run.require_room();
    return std::nullopt;
  }
  if (!run.exists())
    throw InputError(fmt::format("{}: nothing to resume: it has no config.json", root));
  if (std::filesystem::exists(run.checkpoint())) return load_checkpoint(run.checkpoint());
  if (std::filesystem::exists(run.model()))
    throw InputError(fmt::format(
        "{}: has a model and no checkpoint.ckpt to go on from; train anew into another -o", root));
  throw InputError(
      fmt::format("{}: no checkpoint yet; give the first command again, without --resume", root));
}

json make_config(const TrainRequest& request, const PlannedOptions& planned, const Scene& scene,
                 const std::string& device) {
  const TrainOptions& options = planned.options;
  json config = {{"tessera", kVersionText},
                 {"commit", kCommitText},
                 {"preset", request.preset},
                 {"ablation", request.ablation.empty() ? json(nullptr) : json(request.ablation)},
                 {"options", to_json(options)},
                 {"scene", std::filesystem::absolute(request.scene).string()},
                 {"train_frames", scene.split_indices(Split::kTrain).size()},
                 {"validation_frames", scene.split_indices(Split::kValidation).size()},
                 {"device", device},
                 {"seed", options.seed},
                 {"made_for", request.made_for}};
  if (const auto file = request.scene / "transforms.json"; std::filesystem::exists(file))
    config["scene_hash"] = source_hash(file);
  if (request.window) config["window"] = text_of(*request.window);
  if (!request.static_model.empty())
    config["static_model"] = {{"run", std::filesystem::absolute(request.static_model).string()},
                              {"digest", static_model_digest(request.static_model)}};
  // of a training that was stopped before it knew its motion
  if (options.motion == Motion::kAuto && planned.with_nodes)
    config["with_nodes"] = to_json(*planned.with_nodes);
  return config;
}

Scene load_training_scene(const std::filesystem::path& path, const TrainOptions& options,
                          const std::optional<Window>& window, bool held_out) {
  SceneOptions scene_options;
  scene_options.window = window;
  scene_options.background = parse_background(options.background);
  scene_options.allow_static = options.motion == Motion::kNone;
  const SceneFiles files(path, scene_options.allow_static, window);
  scene_options.load_pixels = false;
  check_fits_memory(files.load(scene_options), {held_out, options.moving_weight > 0},
                    machine_memory());
  scene_options.load_pixels = true;
  if (!held_out) scene_options.pixels_of = {Split::kTrain};
  return scaled_scene(files.load(scene_options), options.train_scale);
}

std::string readout_warning(const Scene& scene, const TrainOptions& options) {
  if (options.motion != Motion::kNodes ||
      std::none_of(scene.frames.begin(), scene.frames.end(),
                   [](const Frame& frame) { return frame.camera.readout != 0; }))
    return "";
  return fmt::format(
      "{}: states readouts of rolling shutters, and motion nodes draw all rows at one time; "
      "--motion pair draws each at its own",
      scene.path);
}

std::vector<std::string> training_warnings(const Scene& scene, const TrainOptions& options) {
  std::vector<std::string> warnings = scene.warnings;
  const int64_t timesteps = scene.timesteps_of(Split::kTrain);
  if (options.motion == Motion::kNone && timesteps > 1)
    warnings.push_back(fmt::format(
        "{}: has {} timesteps, and --motion none makes one static scene of them all, in which what "
        "moves is blurred; for a moving scene choose another preset, for instance balanced",
        scene.path, timesteps));
  return warnings;
}

std::optional<std::string> complete_cloud(
    Scene& scene, const TrainOptions& options, const std::optional<Window>& window,
    const std::function<std::unique_ptr<PixelSearch>()>& device,
    std::vector<std::string>& warnings) {
  if (!options.sweep || !scene.points.position.empty()) return std::nullopt;
  RigCloud cloud = is_as_filed(scene, options)
                       ? rig_cloud(SceneFrames(scene), {}, device)
                       : rig_cloud(FolderFrames(scene.path, window), {}, device);
  if (cloud.points.position.empty()) return std::nullopt;
  const std::string found = summary(cloud);
  if (const std::string warning = motion_warning(cloud); !warning.empty())
    warnings.push_back(warning);
  scene.points = std::move(cloud.points);
  return found;
}

namespace {

std::optional<std::string> resolve_exposure(const Scene& scene, TrainOptions& options) {
  constexpr double kVisible = 0.03;
  if (options.exposure != ExposureGains::kAuto) return std::nullopt;
  options.exposure = ExposureGains::kNone;
  if ((scene.is_static && scene.static_of == 0) || scene.had_alpha) return std::nullopt;
  const std::vector<CameraGain> gains = measured_gains(scene);
  const auto known = std::count_if(gains.begin(), gains.end(), [](const CameraGain& camera) {
    return camera.pairs >= kLeastColourPairs;
  });
  if (known < 2)
    return "exposure: too few points are seen by several cameras to compare their colours; pass "
           "--exposure camera where they differ";
  const double largest = largest_difference(gains);
  if (largest <= kVisible)
    return fmt::format("exposure: the gains of {} cameras differ by at most {:.1f} %", known,
                       100 * largest);
  options.exposure = ExposureGains::kCamera;
  return fmt::format(
      "exposure: the gains of {} cameras differ by up to {:.0f} %, so a gain per camera and "
      "channel "
      "is learned; --exposure none turns this off",
      known, 100 * largest);
}

std::optional<std::string> resolve_clocks(const Scene& scene, TrainOptions& options) {
  if (options.clocks != Clocks::kAuto) return std::nullopt;
  options.clocks = Clocks::kFixed;
  if (options.motion == Motion::kNodes || options.validation_share > 0) return std::nullopt;
  std::set<std::string> training;
  for (const int i : scene.split_indices(Split::kTrain))
    training.insert(scene.frames[size_t(i)].camera_name);
  const auto measured = std::count_if(training.begin(), training.end(), [&](const auto& camera) {
    return scene.measured_clocks.contains(camera);
  });
  if (measured == 0 || training.size() < 2) return std::nullopt;
  options.clocks = Clocks::kLearn;
  return fmt::format(
      "clocks: motion or sound moved those of {} of {} cameras, so a rest of each is learned; "
      "--clocks fixed turns this off",
      measured, training.size());
}

std::optional<std::string> resolve_near_plane(const std::optional<double>& nearest,
                                              TrainOptions& options) {
  if (options.near_plane > 0) return std::nullopt;
  options.near_plane = nearest ? *nearest / 2 : TrainOptions().near_plane;
  if (!nearest)
    return fmt::format("near plane: no camera sees enough points to measure it, so it is {:g}",
                       options.near_plane);
  return fmt::format(
      "near plane: the points nearest to the cameras are at a depth of {:.3g}, so Gaussians nearer "
      "than {:.3g} are not drawn; --near-plane {:g} is the fixed distance of 3DGS",
      *nearest, options.near_plane, TrainOptions().near_plane);
}

std::optional<std::string> resolve_clear_distance(const std::optional<double>& nearest,
                                                  TrainOptions& options) {
  constexpr double kShare = 0.8;
  if (options.clear_distance >= 0) return std::nullopt;
  options.clear_distance = 0;
  if (!nearest) return std::nullopt;
  options.clear_distance = kShare * *nearest;
  return fmt::format(
      "clear distance: Gaussians in the view of a training camera nearer than {:.3g} are removed; "
      "--clear-distance 0 keeps them",
      options.clear_distance);
}

std::optional<std::string> resolve_budget(const Scene& scene, TrainOptions& options) {
  const std::optional<double> pixels = limit_by_shown_pixels(scene, options);
  if (!pixels) return std::nullopt;
  return fmt::format(
      "budget: training images show {:.0f} pixels on average, so up to {} Gaussians grow; "
      "--gaussians-per-pixel 0 leaves it to --peak-gaussians",
      *pixels, options.peak_gaussians);
}

std::optional<std::string> resolve_noise(const Scene& scene, TrainOptions& options) {
  constexpr double kVisible = 1;  // levels; C2 of SSIM is that of the contrast of 5.4
  if (options.noise >= 0) return std::nullopt;
  options.noise = image_noise(scene);
  if (options.noise < kVisible) return std::nullopt;
  return fmt::format(
      "noise: the images have noise of {:.1f} of 255 levels, which the loss allows for; --noise 0 "
      "turns this off",
      options.noise);
}

/// What follows the score of nodes in a sentence.
std::string said_of_nodes(const MotionTrial& trial) {
  if (!trial.nodes_move()) return ", which hardly move,";
  if (!trial.many_nodes_psnr) return "";
  return fmt::format(" ({:.1f} with {} of them, so there are {})", *trial.many_nodes_psnr,
                     kManyNodes, trial.prefers_many_nodes() ? kManyNodes : kFewNodes);
}

}  // namespace

std::vector<std::string> resolve_by_cloud(const Scene& scene, TrainOptions& options) {
  std::vector<std::string> lines;
  std::optional<double> nearest;
  if (options.near_plane <= 0 || options.clear_distance < 0) nearest = nearest_depth(scene);
  for (const auto& line :
       {resolve_near_plane(nearest, options), resolve_clear_distance(nearest, options),
        resolve_exposure(scene, options), resolve_clocks(scene, options),
        resolve_noise(scene, options), resolve_budget(scene, options)})
    if (line) lines.push_back(*line);
  return lines;
}

bool resolve_motion(Backend& backend, const Scene& scene,
                    const std::optional<TrainOptions>& with_nodes, TrainOptions& options,
                    const std::function<bool()>& stop,
                    const std::function<void(const std::string&)>& say) {
  if (options.motion != Motion::kAuto) return true;
  if (const std::string reason = reason_against_trial(scene, options); !reason.empty()) {
    options.motion = Motion::kPair;
    say(fmt::format("motion: dynamic Gaussians, as {}; --motion nodes does otherwise", reason));
    return true;
  }
  TrainOptions nodes = with_nodes.value_or(options);
  nodes.motion = Motion::kNodes;
  nodes.exposure = options.exposure;
  nodes.near_plane = options.near_plane;
  nodes.clocks = Clocks::kFixed;
  nodes.learn_readouts = false;
  nodes.validation_share = options.validation_share;
  limit_by_shown_pixels(scene, nodes);
  say("motion: short trainings say whether motion nodes or dynamic Gaussians show more");
  const std::optional<MotionTrial> trial = try_motion(backend, scene, nodes, stop);
  if (!trial) return false;
  const bool chosen = trial->prefers_nodes();
  if (chosen)
    options = nodes;
  else
    options.motion = Motion::kPair;
  if (trial->prefers_many_nodes()) options.motion_nodes = kManyNodes;
  say(fmt::format(
      "motion: {} frames held out have {:.1f} dB with motion nodes{} and {:.1f} dB with dynamic "
      "Gaussians, so {}; --motion {} does otherwise",
      trial->frames, trial->nodes_psnr, said_of_nodes(*trial), trial->dynamic_psnr,
      chosen ? "nodes carry the scene" : "Gaussians are dynamic or static",
      chosen ? "pair" : "nodes"));
  return true;
}

}  // namespace tessera
