// Which cameras of a rig have another frame rate than most, and what rates are called.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

/// Which rates differ by more than 2 % from the median one. `frame_seconds`: the median distance of
/// each camera's frames in seconds, 0 where it has one frame and no rate, which never differs.
std::vector<char> odd_rates(const std::vector<double>& frame_seconds);

/// How many have this rate, within 2 %; 0 of no rate. `frame_seconds` as above.
int64_t cameras_of_rate(double seconds, const std::vector<double>& frame_seconds);

/// "30 frames/s" of each camera; those that do not differ have the text of the median one.
std::vector<std::string> rate_texts(const std::vector<double>& frame_seconds);

/// What is kept where `fps` is more than any camera has; else "".
std::string fps_warning(double fps, const std::vector<double>& frame_seconds);

}  // namespace tessera
