// Core i of N over T timesteps begins at i T / N, rounded down.
#include "ingest/clocks/windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "kernels/base/errors.h"

namespace tessera {

Window window_of_text(const std::string& text, const std::string& option) {
  Window window;
  int end = 0;
  const int read = std::sscanf(text.c_str(), "%ld/%ld%n", &window.index, &window.count, &end);
  if (read != 2 || size_t(end) != text.size() || window.index < 1 || window.index > window.count)
    throw InputError(
        fmt::format("{} {}: expected I/N with I from 1 to N, e.g. 1/12", option, text));
  --window.index;
  return window;
}

std::string text_of(const Window& window) {
  return fmt::format("{}/{}", window.index + 1, window.count);
}

TimestepRange range_of(const Window& window, int64_t timesteps) {
  check(window.index >= 0 && window.index < window.count && window.overlap >= 0,
        "a window is one of those that there are");
  if (2 * window.count > timesteps)
    throw InputError(
        fmt::format("window {}: the clip has {} timesteps, and a window needs two; make {} windows "
                    "of it at most",
                    text_of(window), timesteps, std::max<int64_t>(1, timesteps / 2)));
  const auto begin = [&](int64_t index) { return index * timesteps / window.count; };
  return {std::max<int64_t>(begin(window.index) - window.overlap, 0),
          std::min(begin(window.index + 1) - 1 + window.overlap, timesteps - 1)};
}

}  // namespace tessera
