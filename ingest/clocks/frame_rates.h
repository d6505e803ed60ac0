// Names the cameras of a rig whose frame rate is not that of the others.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// Which rates differ by more than 2 % from the median one. `frame_seconds`: the median distance of
/// each camera's frames in seconds, 0 where it has one frame and no rate, which never differs.
std::vector<char> odd_rates(const std::vector<double>& frame_seconds);

/// "cam01 has 30 frames/s, the others 24", and what comes of it; empty where all rates are alike.
/// `cameras`: names; `frame_seconds`: as above.
std::string rate_warning(const std::vector<std::string>& cameras,
                         const std::vector<double>& frame_seconds);

}  // namespace tessera
