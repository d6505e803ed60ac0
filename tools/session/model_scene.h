// The scene that a model was trained on, wherever it lies by now. A model is named by the argument
// of a command: an OUT of `tessera run`, a run folder, the folder of a clip in windows, or a file
// in a run folder.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "ingest/clocks/windows.h"

namespace tessera {

/// Of the scene that the training has named, the scene in OUT (which was moved with the run) and
/// the one that the windows of a clip were last trained with the first that is as it was trained
/// on, else the first that is there; "" where none is.
std::string scene_of_model(const std::filesystem::path& model);
/// The same. Errors: InputError that asks for --scene.
std::filesystem::path require_scene_of(const std::filesystem::path& model);

/// Whether `folder` is an OUT of `tessera run`, by its stages.json.
bool is_run_output(const std::filesystem::path& folder);
/// Errors: InputError where `folder` is no `what`, such as "capture", but an OUT of `tessera run`
/// or a run folder.
void refuse_trained(const std::filesystem::path& folder, const char* what);

/// A line where `scene`, which is not "", is not as that model was trained on: it may hold out
/// other cameras. "" else.
std::string changed_scene(const std::filesystem::path& model, const std::string& scene);

/// The core of the window that such a model was trained on, where `scene` is its scene, by place or
/// by content; nothing of a whole clip.
std::optional<Window> core_of_model(const std::filesystem::path& model,
                                    const std::filesystem::path& scene);

}  // namespace tessera
