// Medians of the means per axis, and a stable sort by Morton codes.
#include "static3d/transform/scene_box.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/base/median.h"
#include "kernels/math/sort_keys.h"

namespace tessera {

bool SceneBox::is_far(const Vec3<float>& mean, float factor) const {
  if (!(half_extent > 0)) return false;
  for (int k = 0; k < 3; ++k)
    if (std::abs(mean[k] - centre[k]) > factor * half_extent) return true;
  return false;
}

SceneBox scene_box(const GaussianModel& model) {
  return box_of_means({model.static_set.values(), model.dynamic_set.values()});
}

SceneBox box_of_means(const std::vector<GaussianSpans<const float>>& sets) {
  SceneBox box;
  std::vector<float> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const GaussianSpans<const float>& set : sets)
      for (int64_t n = 0; n < set.count; ++n)
        if (const float x = set.at(kMean, n)[axis]; std::isfinite(x)) values.push_back(x);
    if (values.empty()) return box;
    box.centre[axis] = median_in_place(values);
    for (float& x : values) x = std::abs(x - box.centre[axis]);
    box.half_extent = std::max(box.half_extent, 2 * median_in_place(values));
  }
  return box;
}

std::vector<int64_t> morton_order(const GaussianSpans<const float>& set) {
  LocalityBox box{{INFINITY, INFINITY, INFINITY, 0}, {-INFINITY, -INFINITY, -INFINITY, 0}};
  for (int64_t n = 0; n < set.count; ++n)
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], set.at(kMean, n)[k]);
      box.high[k] = std::max(box.high[k], set.at(kMean, n)[k]);
    }
  std::vector<uint64_t> codes(size_t(set.count));
  for (int64_t n = 0; n < set.count; ++n) {
    const float* const mean = set.at(kMean, n);
    codes[size_t(n)] = morton_code(box, mean[0], mean[1], mean[2]);
  }
  std::vector<int64_t> order(size_t(set.count));
  std::iota(order.begin(), order.end(), int64_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return codes[size_t(a)] < codes[size_t(b)]; });
  return order;
}

}  // namespace tessera
