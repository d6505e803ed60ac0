// The time that the cameras of a rig film together. A camera that begins late, stops early or has
// another clock does not shorten it for all: it gives what it has.
#pragma once
#include <cstddef>
#include <vector>

#include "ingest/clocks/frame_window.h"

namespace tessera {

/// The longest interval in which at no time more than `missing` cameras do not film: from latest
/// first to earliest last frame for 0. Each clip: its frames' times on the rig's clock, seconds,
/// increasing, not empty. Empty where there is none.
TimeInterval longest_interval(const std::vector<std::vector<double>>& clips, size_t missing);

struct SharedTime {
  TimeInterval interval;           // empty: the cameras share none
  std::vector<char> films_all_of;  // one a camera; 0: it begins in the interval, or ends in it
};

/// What all cameras film or, where that wins a tenth of the clip and two timesteps at least, the
/// longest interval in which at most a quarter of them, one of three to seven, is missing. `clips`
/// as above. Timesteps are counted within `window`, whose rate is not looked at: those of the
/// capture are counted.
SharedTime shared_time(const std::vector<std::vector<double>>& clips, const FrameWindow& window);

}  // namespace tessera
