// Names the cameras of a rig whose frame rate is not that of the others.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// "cam01 has 30 frames/s, the others 24", and what to do about it; empty where all rates are alike
/// within 2 %. The others' rate is the median. `cameras`: names; `frame_seconds`: the median
/// distance of each camera's frames in seconds, 0 where it has one frame and no rate.
std::string rate_warning(const std::vector<std::string>& cameras,
                         const std::vector<double>& frame_seconds);

}  // namespace tessera
