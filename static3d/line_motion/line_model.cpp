// Joins the cores of windows, in the time of the clip, and what motion nodes carry.
#include "static3d/line_motion/line_model.h"

#include <algorithm>
#include <cmath>

#include "recon4d/model/element_edits.h"
#include "static3d/line_motion/carried_lines.h"
#include "static3d/line_motion/lines.h"
#include "static3d/transform/motion_form.h"

namespace tessera {
namespace {

/// The Gaussians of a window that its core has, in the time of the clip.
GaussianSet core_of(const GaussianModel& model, const FileWindow& window, bool is_first,
                    bool is_last) {
  const GaussianSet plain = plain_velocity_form(model);
  const auto times = plain.values();
  std::vector<int64_t> inside;
  for (int64_t n = 0; n < plain.count(); ++n) {
    const double t = clip_time(window, double(*times.at(kMeanTime, n)));
    if ((is_first || t >= window.drawn.low) && (is_last || t < window.drawn.high))
      inside.push_back(n);
  }
  GaussianSet core = select_elements(plain, inside);
  const double length = window.time.high - window.time.low;
  const GaussianSpans<float> values = core.values();
  for (int64_t n = 0; n < core.count(); ++n) {
    *values.at(kMeanTime, n) = float(clip_time(window, double(*values.at(kMeanTime, n))));
    *values.at(kLogScaleTime, n) += float(std::log(length));
    for (int k = 0; k < 3; ++k) values.at(kVelocity, n)[k] /= float(length);
  }
  return core;
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
  for (size_t i = 0; i < windows.windows.size(); ++i)
    cores.push_back(
        core_of(windows.load(int(i)), windows.windows[i], i == 0, i + 1 == windows.windows.size()));
  joined.dynamic_set = joined_lines(cores);
  joined.drawing.time_filter = 0;
  joined.drawing.sh_time_degree = 0;
  return joined;
}

}  // namespace tessera
