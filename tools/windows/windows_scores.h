// The scores of a clip that was trained window by window: each window is scored in its core, by its
// model, and the scores are joined.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "recon4d/evaluation/evaluate.h"
#include "tools/session/windows_folder.h"

namespace tessera {

/// With a progress bar. As score_splits of one model, times being those of the clip, with `windows`
/// (how many), `borders` (as of BorderScore) of each split, and counts of Gaussians: `num_dynamic`
/// over all windows, `peak_gaussians` of one with the static set. `splits`: those that have no
/// frame are left out. `still_scene`: what stands still in the clip (unpack --static), by which
/// pixels move; "": by the frames of each window. Errors: InputError: windows that are not trained,
/// a scene that is gone; as load_scene; Interrupted.
nlohmann::json score_windows(Backend& backend, const WindowModels& models,
                             const std::filesystem::path& scene, const std::vector<Split>& splits,
                             const EvaluateOptions& options = {},
                             const std::filesystem::path& still_scene = {});

/// The same of a folder of windows, on the scene that they were trained on.
nlohmann::json score_windows(Backend& backend, const WindowsFolder& folder,
                             const std::vector<Split>& splits, const EvaluateOptions& options = {});

}  // namespace tessera
