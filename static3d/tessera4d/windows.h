// Intervals of normalised time, and windows: parts of a long clip whose dynamic Gaussians are
// stored in a time of their own. Each window is drawn in its core alone, and cores tile the clip.
// Source: docs/reference/tessera4d.md, section 6.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/light_gain.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// From one timestep to another, normalised time.
struct Interval {
  double low = 0, high = 1;
};
nlohmann::json list_of(const Interval& interval);

/// Both intervals in t of the whole clip.
struct FileWindow {
  Interval time;   // of its tau = 0 and tau = 1: what it was trained on
  Interval drawn;  // its core, within `time`: where low <= t < high, the last one at 1, too
  LightGain light = kSameLight;  // of static Gaussians while it is drawn
};
nlohmann::json to_json(const FileWindow& window);

/// The window's time tau at t of the clip, and the way back.
double window_time(const FileWindow& window, double t);
double clip_time(const FileWindow& window, double tau);
/// The window's time in seconds, where the whole clip has `clip`.
TimeAxis window_axis(const FileWindow& window, const TimeAxis& clip);

/// The window that is drawn at t; the first or last one beyond the clip. Not of an empty list.
int window_at(const std::vector<FileWindow>& windows, double t);

/// The models of windows, which are loaded one after another.
struct WindowModels {
  std::vector<FileWindow> windows;
  std::function<GaussianModel(int)> load;  // by index; in the time of the window
};

/// Why these cannot be the windows of a file; "" where they can.
std::string wrong_windows(const std::vector<FileWindow>& windows);

}  // namespace tessera
