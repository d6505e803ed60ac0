// What: medians per axis.
// Not: exact to the middle of two for even counts; the upper one serves.
#include "static3d/transform/scene_box.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"

namespace tessera {

bool SceneBox::is_far(const Vec3<float>& mean, float factor) const {
  if (!(half_extent > 0)) return false;
  for (int k = 0; k < 3; ++k)
    if (std::abs(mean[k] - centre[k]) > factor * half_extent) return true;
  return false;
}

SceneBox scene_box(const GaussianModel& model) {
  SceneBox box;
  std::vector<float> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
      for (int64_t n = 0; n < set->count(); ++n)
        if (const float x = set->values().at(kMean, n)[axis]; std::isfinite(x)) values.push_back(x);
    if (values.empty()) return box;
    box.centre[axis] = median_in_place(values);
    for (float& x : values) x = std::abs(x - box.centre[axis]);
    box.half_extent = std::max(box.half_extent, 2 * median_in_place(values));
  }
  return box;
}

}  // namespace tessera
