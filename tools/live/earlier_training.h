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
inline constexpr const char* kSceneFiles = "files of the scene";

/// Gives a request of a scene, a run, a window and a static model what the command line says of its
/// training. `files`: the content of the scene, for kSceneFiles.
void take_arguments(const TrainArguments& arguments, PlannedOptions planned,
                    const std::string& files, TrainRequest& request);

/// Its request is that of config.json. Of a training by a version that did not record it, preset,
/// ablation and options, where it was of this scene; null where it was of another.
RunRecord record_of(const RunFolder& run, const std::filesystem::path& scene);

/// A finished run would be replaced.
InputError finished_run_error(const std::filesystem::path& folder,
                              const std::vector<std::string>& changed);

/// The warning where the checkpoint of an unfinished training makes room for another request.
std::string text_of_aside(const std::filesystem::path& checkpoint,
                          const std::vector<std::string>& changed,
                          const std::filesystem::path& aside);

/// What the training of a finished record printed at its end: the last event of its log.
nlohmann::json recorded_result(const RunFolder& run);

}  // namespace tessera
