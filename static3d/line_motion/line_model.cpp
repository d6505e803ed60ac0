// Joins the cores of windows, in the time of the clip, and what motion nodes carry.
#include "static3d/line_motion/line_model.h"

#include <algorithm>
#include <iterator>
#include <utility>

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

/// The windows at which what stands still comes into another light; the first one, too.
std::vector<size_t> light_begins(const std::vector<FileWindow>& windows) {
  std::vector<size_t> begins;
  for (size_t i = 0; i < windows.size(); ++i) {
    LightGain change = windows[i].light;
    for (size_t c = 0; c < change.size() && !begins.empty(); ++c)
      change[c] /= windows[begins.back()].light[c];
    if (begins.empty() || !is_same(change)) begins.push_back(i);
  }
  return begins;
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
  const std::vector<size_t> lights = light_begins(windows.windows);
  if (lights.size() > 1) joined.static_set = GaussianSet(SetForm::kStatic, 1);
  std::vector<GaussianSet> lit;  // what stands still, in each light
  for (size_t i = 0; i < windows.windows.size(); ++i) {
    GaussianModel model = windows.load(int(i));
    GaussianSet moving = plain_velocity_form(model);
    model.dynamic_set.resize(0);
    if (const size_t l = lit.size(); lights.size() > 1 && l < lights.size() && lights[l] == i) {
      const size_t end = l + 1 < lights.size() ? lights[l + 1] : windows.windows.size();
      lit.push_back(
          lines_within(lines_of(model, drawn_degree(model), kLongLife), FileWindow{},
                       {windows.windows[i].drawn.low, windows.windows[end - 1].drawn.high}));
    }
    model.static_set.resize(0);
    model.dynamic_set = std::move(moving);
    cores.push_back(lines_within(lines_of(model, drawn_degree(model), kLongLife),
                                 windows.windows[i], windows.windows[i].drawn));
  }
  std::move(lit.begin(), lit.end(), std::back_inserter(cores));
  joined.dynamic_set = joined_lines(cores);
  joined.drawing.time_filter = 0;
  joined.drawing.sh_time_degree = 0;
  return joined;
}

}  // namespace tessera
