// Chooses the frames of each camera by their times on the clock of the rig. A chosen frame keeps
// its time.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Seconds on the rig's clock; empty where last < first.
struct TimeInterval {
  double first = 0, last = 0;
  bool empty() const { return last < first; }
};

struct FrameWindow {
  double start = 0;                // seconds after the first time of the clip
  std::optional<double> duration;  // seconds; to the end of the clip by default
  std::optional<double> fps;       // keeps the nearest frame of each start + k / fps
  std::optional<int64_t> frames;   // the first N of these times
};

/// Errors: InputError that begins with `where`: the window starts after the end of `clip`.
void check_start(const FrameWindow& window, const TimeInterval& clip, const std::string& where);

/// Indices of the kept frames of one clip, increasing. `seconds`: its frames' times on the rig's
/// clock, increasing; h: half their median distance. The window is [start − h, start + duration −
/// h), so that cameras whose clocks differ by less than half a frame keep equally many frames;
/// where the clip ends it, its end is last + h. With `fps` a frame is kept for the
/// time it is nearest to, if not farther than 0.5 / fps.
std::vector<size_t> choose_frames(const std::vector<double>& seconds, const FrameWindow& window,
                                  const TimeInterval& clip);

}  // namespace tessera
