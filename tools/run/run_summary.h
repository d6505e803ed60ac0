// The summary that `tessera run` prints on stdout at its end.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/session/held_out_scores.h"

namespace tessera {

/// Quality, number of Gaussians, time and sizes; where the results lie; what to type next. `result`
/// is that of run_stages.
std::string run_summary(const nlohmann::json& result, ScoreDetail detail);

}  // namespace tessera
