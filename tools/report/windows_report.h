// What the report of a clip in windows has in the place of that of one training.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "tools/report/run_records.h"

namespace tessera {

/// `run`: of run_report, whose steps, seconds, sizes, warnings and state become those of all
/// windows, with `windows` and `borders`. Curves and decisions are those of one training, and
/// empty.
void add_windows(const RunRecords& records, nlohmann::json& run);

}  // namespace tessera
