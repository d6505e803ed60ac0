// The box of a scene from the medians of its means, so that a few outliers do not move it, and the
// order of Gaussians along a Morton curve, in which files of splats compress well. Source: failure
// mode E3.
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/gaussians.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Half extents beyond which a Gaussian counts as an outlier  [failure mode E3].
inline constexpr float kFarFactor = 10;

struct SceneBox {
  Vec3<float> centre{};   // median of the finite means, per axis, world units
  float half_extent = 0;  // largest axis of twice the median distance to the centre

  /// Beyond `factor` half extents on some axis. A box without extent has no outliers.
  bool is_far(const Vec3<float>& mean, float factor) const;
};

/// Of the means of both sets.
SceneBox scene_box(const GaussianModel& model);
SceneBox box_of_means(const std::vector<GaussianSpans<const float>>& sets);

/// Elements by the Morton codes of their means in the box of all; equal codes keep their order.
std::vector<int64_t> morton_order(const GaussianSpans<const float>& set);

}  // namespace tessera
