// The scores of a model on the held-out splits of a scene, as the JSON and the text that
// `evaluate`, `train` and `run` share, and their mean and standard deviation over several runs.
// recon4d/evaluation/evaluate.h computes the metrics.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "recon4d/evaluation/evaluate.h"

namespace tessera {

/// Splits other than training that have frames: test before val.
std::vector<Split> held_out_splits(const Scene& scene);
inline const std::vector<Split> kHeldOutSplits{Split::kTest, Split::kVal};

/// The first split's scores at the top level (psnr, ssim, …, per_view) and all under `splits`;
/// splits without scores (null) are left out. Empty object when none has any.
nlohmann::json by_split(const std::vector<Split>& splits,
                        const std::function<nlohmann::json(Split)>& scores_of);

/// Such scores of a model on a scene that is loaded. clip_scores.h has those of a file.
nlohmann::json score_splits(Backend& backend, const GaussianModel& model, const Scene& scene,
                            const std::vector<Split>& splits, const ScoredCallback& scored = {},
                            const EvaluateOptions& options = {});

/// PSNR and SSIM alone, for scores during a training.
inline EvaluateOptions brief_scores() {
  EvaluateOptions options;
  options.structure = StructureDetail::kSsim;
  options.temporal = false;
  return options;
}

/// "27.59", or "n/a" where the value is no number.
std::string number_text(const nlohmann::json& value, int digits);

/// "test views", "validation views" or "training views" for test, val or train.
std::string views_text(const std::string& split);

/// What a PSNR looks like, "good where it stands still, soft where it moves"; "" where there is
/// none. `score`: of a split. Source: docs/explanation/scores.md.
std::string verdict(const nlohmann::json& score);

enum class ScoreDetail { kUsual, kAll };

/// A line per split, "test views (24): PSNR 31.42 dB, SSIM 0.9512", and an indented line each for
/// what else there is: LPIPS, novel views and timesteps apart, moving pixels, the temporal error.
/// kAll adds SSIM with each kind of padding, and scores that could not be computed as "n/a".
std::string scores_text(const nlohmann::json& scores, ScoreDetail detail = ScoreDetail::kUsual);

/// Of objects as score_splits makes them, at least one: {count, splits: {test: {psnr: {mean,
/// sigma}, …}, …}}: every number that all runs have, also inside groups such as novel_view. Sigma
/// is the sample's (n − 1), null for one run.
nlohmann::json over_runs(const std::vector<nlohmann::json>& scores);

/// One line per split: "test PSNR 31.42 ± 0.05 dB, SSIM 0.9512 ± 0.0004 over 3 runs".
std::string over_runs_text(const nlohmann::json& statistics);

}  // namespace tessera
