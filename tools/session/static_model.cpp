// Reads the run folder of the static set, and says what of a window's options it settles.
#include "tools/session/static_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/byte_medians.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/scene_scale.h"
#include "tools/session/model_scene.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

constexpr const char* kRemedy =
    "name the run folder of a training on the scene that `tessera unpack --static` writes";

/// The folder of a finished training.
RunFolder finished_run(const std::filesystem::path& run) {
  const RunFolder folder{run_folder_of(run)};
  if (!folder.exists() || !std::filesystem::exists(folder.model()))
    throw InputError(fmt::format("{}: is no finished training; {}", run.string(), kRemedy));
  return folder;
}

/// Images and masks of the scene that the run was trained on.
std::vector<Frame> read_stills(const RunFolder& folder, const TrainOptions& options) {
  const std::filesystem::path path = scene_of_model(folder.root);
  if (path.empty())
    throw InputError(
        fmt::format("{}: its scene {} is gone; write it again by `tessera unpack "
                    "--static`",
                    folder.root.string(), folder.scene()));
  SceneOptions scene_options;
  scene_options.allow_static = true;
  scene_options.background = parse_background(options.background);
  Scene scene = load_scene(path, scene_options);
  if (scene.static_of == 0)
    throw InputError(
        fmt::format("{}: was trained on {}, which is not what stands still in a clip; {}",
                    folder.root.string(), path.string(), kRemedy));
  return scaled_scene(std::move(scene), options.train_scale).frames;
}

/// Of a camera, as it was learnt with the static set; 1 where none was.
LightGain learnt_gain(const StaticModel& shared, const std::string& camera) {
  if (!shared.exposure.is_object()) return kSameLight;
  return shared.exposure.value("gains", nlohmann::json::object()).value(camera, kSameLight);
}

/// The median of up to nine frames, spread over the window; empty where none has pixels.
std::vector<uint8_t> median_of(const std::vector<const Frame*>& frames) {
  constexpr int64_t kMost = 9;
  const auto total = int64_t(frames.size()), count = std::min(kMost, total);
  std::vector<const std::vector<uint8_t>*> images;
  for (int64_t i = 0; i < count; ++i)
    images.push_back(&frames[size_t(even_spread(i, count, total))]->image.data);
  return images.empty() ? std::vector<uint8_t>{} : lower_medians(images);
}

}  // namespace

StaticModel load_static_model(const std::filesystem::path& run) {
  const RunFolder folder = finished_run(run);
  StaticModel shared;
  shared.run = folder.root;
  shared.options = train_options_from_json(folder.read_config().at("options"));
  shared.stills = read_stills(folder, shared.options);
  shared.model = load_model(folder.model());
  if (shared.model.dynamic_set.count() > 0 || shared.model.static_set.form() != SetForm::kStatic)
    throw InputError(fmt::format("{}: has Gaussians that move; {}", folder.root.string(), kRemedy));
  if (std::filesystem::exists(folder.exposure()))
    shared.exposure = nlohmann::json::parse(read_text_file(folder.exposure()), nullptr, false);
  return shared;
}

void adopt_rules(const StaticModel& shared, TrainOptions& options) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(fmt::format("--static-model {}: {}", shared.run.string(), what));
  };
  const TrainOptions& of_static = shared.options;
  if (options.motion == Motion::kNone)
    refuse("a window has what moves; leave out --motion none and --static");
  if (options.motion == Motion::kNodes)
    refuse("motion nodes carry static Gaussians; pass --motion pair");
  if (options.environment) refuse("an environment is learnt with static Gaussians; leave it out");
  if (options.filter_3d != Filter3d::kNone)
    refuse("--filter-3d changes static Gaussians; leave it out");
  if (options.densification == Densification::kMcmc)
    refuse("MCMC moves static Gaussians; take another --densification");
  if (options.exposure == ExposureGains::kFrame)
    refuse("it has no gains of the window's frames; pass --exposure camera");
  if (options.train_scale != of_static.train_scale || options.background != of_static.background)
    refuse(fmt::format(
        "was trained with --train-scale {:g} and --background {}; the windows need the same",
        of_static.train_scale, of_static.background));
  static_cast<DrawingRules&>(options) = static_cast<const DrawingRules&>(of_static);
  if (options.motion == Motion::kAuto) options.motion = Motion::kPair;
  options.exposure = of_static.exposure;
  options.sh_interval = 1;
}

void share_limits(const StaticModel& shared, int64_t count, const ShippedBytes& shipped_bytes,
                  TrainOptions& options) {
  const auto share = [&](int64_t& limit, int64_t of_static, const char* name, const char* unit) {
    if (limit <= of_static)
      throw InputError(fmt::format(
          "--{} {}: is of the clip, whose static set has {} {} already; pass more, or train {} "
          "with less",
          name, limit, of_static, unit, shared.run.string()));
    limit = of_static + std::max<int64_t>(1, (limit - of_static) / count);
  };
  if (options.max_gaussians > 0)
    share(options.max_gaussians, shared.model.static_set.count(), "max-gaussians", "Gaussians");
  if (options.max_bytes > 0)
    share(options.max_bytes, shipped_bytes(shared.model), "max-bytes", "bytes");
}

void check_world(const StaticModel& shared, const Scene& scene) {
  const Similarity &ours = shared.model.prepared_from_source, &theirs = scene.prepared_from_source;
  if (ours.scale == theirs.scale && ours.rotation == theirs.rotation &&
      ours.translation == theirs.translation)
    return;
  throw InputError(
      fmt::format("--static-model {}: is of another world than {}; write the scene of what stands "
                  "still again and train it anew",
                  shared.run.string(), scene.path));
}

std::map<std::string, LightGain> take_light(const Scene& scene, std::vector<Frame>& stills) {
  std::map<std::string, std::vector<const Frame*>> frames;
  for (const Frame& frame : scene.frames)
    if (!frame.image.data.empty()) frames[frame.camera_name].push_back(&frame);
  std::map<std::string, LightGain> gains;
  for (Frame& still : stills) {
    const std::vector<uint8_t> median = median_of(frames[still.camera_name]);
    if (median.size() != still.image.data.size()) continue;  // a held-out camera without pixels
    const LightGain gain = light_gain(median, still.image.data);
    still.image.data = times_light(still.image.data, gain);
    gains[still.camera_name] = gain;
  }
  return gains;
}

void adopt_light(const Scene& scene, StaticModel& shared, TrainOptions& options) {
  constexpr double kLeastOfCamera = 0.03;
  const std::map<std::string, LightGain> gains = take_light(scene, shared.stills);
  LightGain sum = {0, 0, 0}, weights = {0, 0, 0};
  for (const Frame& still : shared.stills) {
    const auto gain = gains.find(still.camera_name);
    if (still.split != Split::kTrain || gain == gains.end()) continue;
    shared.of_camera[still.camera_name] = gain->second;
    const LightGain learnt = learnt_gain(shared, still.camera_name);
    for (size_t c = 0; c < 3; ++c) {
      sum[c] += learnt[c] * gain->second[c];
      weights[c] += learnt[c];
    }
  }
  for (size_t c = 0; c < 3; ++c) shared.light[c] = weights[c] > 0 ? sum[c] / weights[c] : 1;
  if (is_same(shared.light)) shared.light = kSameLight;
  for (auto& [name, gain] : shared.of_camera)
    for (size_t c = 0; c < 3; ++c) {
      gain[c] /= shared.light[c];
      if (options.exposure == ExposureGains::kNone && std::abs(gain[c] - 1) > kLeastOfCamera)
        options.exposure = ExposureGains::kCamera;
    }
  apply_light(shared.light, shared.model.static_set);
}

LearntRows shared_exposure(const StaticModel& shared, const Scene& scene,
                           const TrainOptions& options) {
  const ExposureRows rows = exposure_rows(scene, training_frames(scene), options);
  LearntRows state;
  if (shared.exposure.is_object())
    state =
        exposure_of_json(shared.exposure, rows, options, RunFolder{shared.run}.exposure().string());
  else
    state.reset(int64_t(rows.names.size()), exposure_width(options.exposure));
  if (state.width() != 3) return state;  // affine maps stay as they are
  for (size_t row = 0; row < rows.names.size(); ++row)
    if (const auto found = shared.of_camera.find(rows.names[row]); found != shared.of_camera.end())
      for (size_t c = 0; c < 3; ++c)
        state.value[int64_t(3 * row + c)] += float(std::log(found->second[c]));
  return state;
}

std::string static_model_digest(const std::filesystem::path& run) {
  return source_hash(finished_run(run).model());
}

}  // namespace tessera
