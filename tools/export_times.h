// What: the moments that `tessera export` writes: from --frames, --fps, --time and --range.
// Not: files or models.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct ExportTimes {
  std::optional<int64_t> frames = {};
  std::optional<double> fps = {};   // moments per unit of the capture's clock
  std::optional<double> time = {};  // normalised
  std::string range = {};           // "A:B"; empty: the whole clip
};

/// A part of the clip in normalised time, 0 ≤ begin < end ≤ 1.
struct TimeRange {
  double begin = 0, end = 1;
};

/// "A:B", "A:" or ":B". Numbers are normalised time (0 first, 1 last); with the unit s they are
/// seconds of the capture's clock since the clip's first moment. Either end may have either unit.
/// Errors: InputError naming --range: no such form, ends outside the clip, A not before B.
TimeRange parse_time_range(const std::string& text, const TimeAxis& axis);

/// Ascending normalised times. In this order: --time, that moment alone; --frames, evenly from the
/// first moment of the range to the last; --fps, so far apart from the first on; else 24 a unit of
/// the capture's clock, at most 300, and the first moment alone where nothing moves.
/// Errors: InputError naming the option.
std::vector<double> export_times(const ExportTimes& request, const TimeAxis& axis, bool moves);

}  // namespace tessera
