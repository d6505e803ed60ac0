// The charts of the live page.
#pragma once
#include <string>
#include <vector>

#include "tools/report/log_events.h"

namespace tessera {

/// SVG; those without a point are left out. Curves of test views have the colour of the preset.
std::vector<std::string> run_charts(const std::string& preset, const RunCurves& curves);

}  // namespace tessera
