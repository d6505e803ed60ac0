// Reads the run folder of the static set, and says what of a window's options it settles.
#include "tools/session/static_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/scene_scale.h"
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

ExposureState shared_exposure(const StaticModel& shared, const Scene& scene,
                              const TrainOptions& options) {
  return exposure_of_json(shared.exposure, exposure_rows(scene, training_frames(scene), options),
                          options, RunFolder{shared.run}.exposure().string());
}

std::string static_model_digest(const std::filesystem::path& run) {
  return source_hash(finished_run(run).model());
}

}  // namespace tessera
