// Joins the cores of windows, in the time of the clip, and what motion nodes carry.
#include "static3d/line_motion/line_model.h"

#include <algorithm>
#include <cmath>

#include "static3d/line_motion/carried_lines.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/piece_lines.h"
#include "static3d/transform/motion_form.h"

namespace tessera {
namespace {

/// What a part of the clip has of lines in the time of a window.
GaussianSet lines_within(const GaussianSet& lines, const FileWindow& window, const Interval& part) {
  const GaussianSpans<const float> from = lines.values();
  const double length = window.time.high - window.time.low;
  return lines_of_pieces(lines,
                         [&](int64_t n) {
                           LinePiece line = line_at(from, n);
                           line.time = clip_time(window, line.time);
                           line.extent *= length;
                           line.velocity /= length;
                           return pieces_within(line, part);
                         })
      .lines;
}

/// Windows from `first` on to the one before `end`.
struct LightPart {
  size_t first, end;
};

/// Parts of the clip in which what stands still is in one light.
std::vector<LightPart> light_parts(const std::vector<FileWindow>& windows) {
  std::vector<LightPart> parts;
  for (size_t i = 0; i < windows.size(); ++i) {
    LightGain change = windows[i].light;
    for (size_t c = 0; c < change.size() && !parts.empty(); ++c)
      change[c] /= windows[parts.back().first].light[c];
    if (parts.empty() || !is_same(change)) parts.push_back({i, i + 1});
    parts.back().end = i + 1;
  }
  return parts;
}

GaussianSet only(const GaussianModel& model, bool moving) {
  GaussianModel part = model.clone_values();
  (moving ? part.static_set : part.dynamic_set).resize(0);
  return lines_of(part, drawn_degree(part), kLongLife);
}

}  // namespace

GaussianModel line_model(const WindowModels& windows, const GaussianModel& still) {
  GaussianModel joined = still.clone_values();
  std::vector<GaussianSet> cores;
  if (!still.nodes.empty()) {
    cores.push_back(lines_of_carried(still.static_set, still.nodes));
    joined.static_set = GaussianSet(SetForm::kStatic, 1);
    joined.nodes = MotionNodes();
  }
  for (size_t i = 0; i < windows.windows.size(); ++i) {
    GaussianModel model = windows.load(int(i));
    model.dynamic_set = plain_velocity_form(model);
    cores.push_back(lines_within(only(model, true), windows.windows[i], windows.windows[i].drawn));
  }
  if (const std::vector<LightPart> parts = light_parts(windows.windows); parts.size() > 1) {
    joined.static_set = GaussianSet(SetForm::kStatic, 1);
    for (const auto& [first, end] : parts)
      cores.push_back(
          lines_within(only(windows.load(int(first)), false), FileWindow{},
                       {windows.windows[first].drawn.low, windows.windows[end - 1].drawn.high}));
  }
  joined.dynamic_set = joined_lines(cores);
  joined.drawing.time_filter = 0;
  joined.drawing.sh_time_degree = 0;
  return joined;
}

}  // namespace tessera
