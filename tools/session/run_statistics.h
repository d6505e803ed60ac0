// What: mean and standard deviation of scores over runs of one scene, e.g. over seeds.
// Not: the scores (held_out_scores.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tessera {

/// Of objects as score_splits makes them, at least one: {count, splits: {test: {psnr: {mean,
/// sigma}, …}, …}}: every number that all runs have, also inside groups such as novel_view. Sigma
/// is the sample's (n − 1), null for one run.
nlohmann::json over_runs(const std::vector<nlohmann::json>& scores);

/// One line per split: "test PSNR 31.42 ± 0.05 dB, SSIM 0.9512 ± 0.0004 over 3 runs".
std::string over_runs_text(const nlohmann::json& statistics);

}  // namespace tessera
