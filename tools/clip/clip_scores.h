// The scores of a clip: each window is scored in its core, by its model, and the scores are joined.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "recon4d/evaluation/evaluate.h"
#include "tools/clip/clip.h"

namespace tessera {

/// With a progress bar. As score_splits of one model, at `scale` times the size of the images that
/// were trained on; of several windows with times of the clip, `windows` (how many), `borders` (as
/// of BorderScore) of each split, and counts of Gaussians: `num_dynamic` over all windows,
/// `peak_gaussians` of one with the static set. `splits`: those that have no frame are left out.
/// Errors: InputError: as load_scene and truth_scale; Interrupted.
nlohmann::json score_clip(Backend& backend, const Clip& clip, const std::filesystem::path& scene,
                          const std::vector<Split>& splits, const EvaluateOptions& options = {},
                          double scale = 1, const ScoredCallback& scored = {});

}  // namespace tessera
