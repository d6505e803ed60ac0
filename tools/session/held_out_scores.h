// What: the scores of a model on the held-out splits of a scene, as the JSON that `evaluate`,
//       `train` and `run` share.
// Not: the metrics (recon4d/evaluation/evaluate.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/evaluation/evaluate.h"

namespace tessera {

/// Splits other than training that have frames: test before val.
std::vector<Split> held_out_splits(const Scene& scene);

/// The first split's scores at the top level (psnr, ssim, …, per_view) and all under `splits`.
/// Empty object when `splits` is empty.
nlohmann::json score_splits(Backend& backend, const GaussianModel& model, const Scene& scene,
                            const std::vector<Split>& splits, std::optional<int64_t> bytes,
                            const ScoredCallback& scored = {}, const EvaluateOptions& options = {});

/// PSNR and SSIM alone, for scores during a training and in benchmarks.
inline EvaluateOptions brief_scores() {
  EvaluateOptions options;
  options.structure = StructureDetail::kSsim;
  options.temporal = false;
  return options;
}

/// Per split: "test PSNR 31.42 dB, SSIM 0.9512 (reflect padding) over 24 views", and a line each of
/// what else there is: LPIPS, new views and timesteps apart, moving pixels, flicker.
std::string scores_text(const nlohmann::json& scores);

}  // namespace tessera
