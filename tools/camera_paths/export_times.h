// The timesteps that `tessera export` writes: from --frames, --fps, --time and --range, else at the
// rate of the capture's cameras.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct ExportTimes {
  std::optional<int64_t> frames = {};
  std::optional<double> fps = {};          // timesteps per unit of the capture's clock
  std::optional<double> time = {};         // normalised
  std::string range = {};                  // "A:B"; empty: the whole clip
  std::optional<double> capture_fps = {};  // of the capture's cameras, where that is known
};

/// The normalised times of each camera's frames, by its name.
using CameraTimesteps = std::map<std::string, std::set<double>>;

/// Frames in a unit of normalised time, of the median camera. Not the number of distinct times,
/// which cameras whose clocks differ by milliseconds multiply. A camera's own: its frames and those
/// that are missing between them (steps of its median distance). Cameras that have one frame
/// (photos) count as one camera together. 0 where there is one time only.
double capture_rate(const CameraTimesteps& cameras);

/// At that rate, evenly from the first time to the last, at most `most`.
std::vector<double> capture_times(const CameraTimesteps& cameras, int64_t most);

/// A part of the clip in normalised time, 0 ≤ begin < end ≤ 1.
struct TimeRange {
  double begin = 0, end = 1;
};

/// "A:B", "A:" or ":B". Numbers are normalised time (0 first, 1 last); with the unit s they are
/// seconds of the capture's clock since the clip's first timestep. Either end may have either unit.
/// Errors: InputError naming --range: no such form, ends outside the clip, A not before B.
TimeRange parse_time_range(const std::string& text, const TimeAxis& axis);

/// Ascending normalised times. In this order: --time, that timestep alone; --frames, evenly from
/// the first timestep of the range to the last; --fps, so far apart from the first on; else those
/// of capture_fps, or 24 a unit of the capture's clock where it is not known, at most 300, and the
/// first timestep alone where nothing moves. Errors: InputError naming the option.
std::vector<double> export_times(const ExportTimes& request, const TimeAxis& axis, bool moves);

}  // namespace tessera
