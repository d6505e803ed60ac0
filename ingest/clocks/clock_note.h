// How the clocks of a rig were aligned, and by how much, in one line.
#pragma once
#include <string>
#include <vector>

#include "ingest/clocks/clock_sync.h"

namespace tessera {

/// "clocks: aligned by motion, by up to 0.0417 s (cam03)". `cameras`: names, one a clock; not
/// empty.
std::string clock_note(const std::vector<std::string>& cameras,
                       const std::vector<ClipClock>& clocks);

}  // namespace tessera
