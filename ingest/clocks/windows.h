// Windows of a long clip: equal parts, each of which is trained as a short clip of its own.
#pragma once
#include <cstdint>
#include <string>

namespace tessera {

/// One of `count` parts of a clip.
struct Window {
  int64_t index = 0;  // from 0
  int64_t count = 1;
  /// Timesteps beyond both ends of its core. A Gaussian of the presets, whose standard deviation is
  /// three frames, reaches 7.3 frames.
  int64_t overlap = 8;

  bool operator==(const Window&) const = default;
};

/// "2/12" is the second of twelve. Errors: InputError naming `option`.
Window window_of_text(const std::string& text, const std::string& option);
std::string text_of(const Window& window);

/// Timesteps by number, both ends included.
struct TimestepRange {
  int64_t first = 0, last = 0;
};

/// The timesteps of a window: its core with those beyond, as far as the clip of `timesteps` goes.
/// The cores of all windows have every timestep once and differ in length by one at most. Errors:
/// InputError: a window would have less than two timesteps.
TimestepRange range_of(const Window& window, int64_t timesteps);

}  // namespace tessera
