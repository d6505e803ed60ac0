// Finds the few cameras that limit a clip: those that begin late, end early or have another clock,
// so that all cameras share much less than the others do.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/clocks/frame_window.h"

namespace tessera {

struct LimitedClip {
  std::vector<std::string> limiting;  // cameras, at most a quarter of all; empty: none limits much
  std::vector<std::string> others;    // the remaining cameras; two or more where some limit
  int64_t timesteps = 0;              // that all cameras share
  int64_t without = 0;                // that the others share
};

/// The fewest cameras without which a tenth of the clip, and two timesteps at least, are won.
/// `cameras`: names; `seconds`: the times of each camera's frames on the clock of the rig,
/// increasing, not empty. Timesteps are counted within `window`, whose rate is not looked at: those
/// of the capture are counted. Of fewer than three cameras none is named, as none could be left
/// out.
LimitedClip limited_clip(const std::vector<std::string>& cameras,
                         const std::vector<std::vector<double>>& seconds,
                         const FrameWindow& window);

/// What the limiting cameras cost; the table of cameras lists the others. Empty where none limits
/// the clip. Errors: InputError that begins with `where`: less than half of the timesteps is left.
std::string limit_warning(const LimitedClip& clip, const std::string& where);

}  // namespace tessera
