// What: the accounts and counts of a model on the command line, as `info` and `evaluate` say them.
// Not: the arithmetic (static3d/tessera4d/size_breakdown.h, static3d/tessera4d/model_histograms.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/session/model_input.h"

namespace tessera {

/// `account`: {memory, and shipped of a Tessera 4D file or, where `with_shipped`, of the one that
/// export would write, which is encoded for it}, sh_degrees, temporal_extents. `path`: as on the
/// command line.
nlohmann::json model_size(const std::string& path, const ModelInput& input, bool with_shipped);

}  // namespace tessera
