// What a training starts from: its scene, the state in its run folder, and its config.json.
#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kernels/backend.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/options/presets.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"

namespace tessera {

/// The scene as a training with these options sees it: its background, one timestep allowed or not.
/// Without `held_out` the frames of other splits have no pixels, as load_scene's pixels_of has it.
/// Errors: as load_scene.
Scene load_training_scene(const std::filesystem::path& path, const TrainOptions& options,
                          const std::optional<Window>& window = {}, bool held_out = true);

/// Of motion nodes where cameras have a rolling shutter; else "".
std::string readout_warning(const Scene& scene, const TrainOptions& options);

/// What a user of these options on this scene may not expect, one line each; with what the scene
/// itself warns of.
std::vector<std::string> training_warnings(const Scene& scene, const TrainOptions& options);

/// Gives a scene without a cloud the one that `tessera ingest` makes by default, unless
/// options.sweep is off: the rig_cloud() of its frames as they are in the files, with those for
/// validation; files of `window` are read again where frames in memory differ in size or
/// background. A line on what was found; none where nothing was. `device`: of rig_cloud().
std::optional<std::string> complete_cloud(
    Scene& scene, const TrainOptions& options, const std::optional<Window>& window,
    const std::function<std::unique_ptr<PixelSearch>()>& device,
    std::vector<std::string>& warnings);

/// Replaces what options leave to a measurement on `scene`, which has its cloud; a line on each.
/// A near plane of 0: by half of nearest_depth(scene), or by the usual one where the cloud has too
/// few points. Exposure `auto`: by `camera` where the measured gains of the training cameras differ
/// by more than 3 %, else by `none`. gaussians_per_pixel: lowers peak_gaussians by the pixels that
/// the training images show.
std::vector<std::string> resolve_by_cloud(const Scene& scene, TrainOptions& options);

/// Replaces motion `auto`: the options become `with_nodes` where a trial on `scene`, which has its
/// cloud, prefers nodes, else their motion is `pair`. False where `stop`, asked before each step of
/// the trial, said so: options stay as they are. `say` is given a line before a trial and one on
/// why.
bool resolve_motion(Backend& backend, const Scene& scene,
                    const std::optional<TrainOptions>& with_nodes, TrainOptions& options,
                    const std::function<bool()>& stop,
                    const std::function<void(const std::string&)>& say);

/// The checkpoint to go on from; nothing for a new training. Errors: InputError: nothing to resume;
/// a new training where a run is.
std::optional<Checkpoint> previous_state(const TrainRequest& request, const RunFolder& run);

/// Tells scenes apart on resume, as they are loaded: names, times, sizes, cameras and masks of the
/// frames, the images that are trained on, and the points. A cloud that the training makes is none
/// of them, as a resumed one makes none.
std::string scene_fingerprint(const Scene& scene);

/// config.json: versions, options, scene, device.
nlohmann::json make_config(const TrainRequest& request, const PlannedOptions& planned,
                           const Scene& scene, const std::string& device);

}  // namespace tessera
