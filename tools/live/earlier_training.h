// What a run folder holds of an earlier training, as plan_run (run_record.h) asks, and its result.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"
#include "tools/cli/run_record.h"
#include "tools/cli/train_arguments.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"

namespace tessera {

/// What identifies a training beside the content of its scene, which the caller adds as
/// kSceneFiles: neither the device, nor where files lie, nor limits of a call.
nlohmann::json asked_of_training(const TrainArguments& arguments, const PlannedOptions& planned,
                                 const std::optional<Window>& window = {},
                                 const std::filesystem::path& static_model = {});
inline constexpr const char* kSceneFiles = "contents of the scene";  // 0.3: "files of"
inline constexpr const char* kWindows = "windows";                   // of the clip, in a request

/// Gives a request of a scene, a run, a window and a static model what the command line says of its
/// training. `files`: the content of the scene, for kSceneFiles.
void take_arguments(const TrainArguments& arguments, PlannedOptions planned,
                    const std::string& files, TrainRequest& request);

/// Of a training, its request is that of config.json; by a version that did not record it, preset,
/// ablation and options, where it was of this scene, and null where it was of another. Of a clip in
/// windows it is that of windows.json, and all of them are finished, or it is not.
RunRecord record_of(const RunFolder& run, const std::filesystem::path& scene);

/// What the training of a finished record printed at its end: the last event of its log.
nlohmann::json recorded_result(const RunFolder& run);

}  // namespace tessera
