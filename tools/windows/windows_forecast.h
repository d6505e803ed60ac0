// What a long clip would take as windows: how many, how much memory each, and how long on one card
// and on several.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "ingest/scene.h"
#include "tools/windows/window_choice.h"

namespace tessera {

struct WindowsForecast {
  int64_t windows = 1;   // 1: the clip is trained as a whole
  nlohmann::json table;  // windows, seconds, images, host_bytes, window_seconds, hours by cards
  std::string line;      // in words; "" where the clip is trained as a whole
  bool fits = true;      // a window into the memory
};

/// As `tessera run --preset balanced` cuts it where `wish` is given. `scene` lists the frames,
/// without pixels; `memory`: bytes that programs can have in all. The seconds are right within a
/// factor of three.
WindowsForecast forecast_windows(const WindowWish& wish, const Scene& scene, int64_t memory,
                                 int threads);

}  // namespace tessera
