// What: a covariance as what a static Gaussian stores of it: logarithms of its deviations and the
//       quaternion of its axes.
// Not: on the path of a step; slices, conversions and demotion need it once per Gaussian, in
// double.
#pragma once
#include "kernels/math/eigen3.h"

namespace tessera {

struct Shape3 {
  Vec3<double> log_scale;  // ln of world units
  Vec4<double> rotation;   // unit quaternion w,x,y,z
};

/// Rounding may leave an eigenvalue at or below 0: deviations are at least 1e-12.
TESSERA_HD inline Shape3 shape_of(const Sym3<double>& covariance) {
  constexpr double kMinVariance = 1e-24;  // world units²: e^{2·log_scale} is a normal float
  const Eigen3 eigen = symmetric_eigen(covariance);
  Shape3 shape;
  for (int k = 0; k < 3; ++k) shape.log_scale[k] = 0.5 * log(max_of(eigen.values[k], kMinVariance));
  shape.rotation = quaternion_from_rotation(eigen.vectors);
  return shape;
}

}  // namespace tessera
