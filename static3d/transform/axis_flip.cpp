// What: products of signs, exact in every bit.
// Not: a loss: nothing is rounded.
#include "static3d/transform/axis_flip.h"

#include <array>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Of the coefficients 0 to 15: each is odd in the axes of its polynomial.
std::array<float, kMaxShCoefficients> sh_signs(const AxisSigns& s) {
  const float xy = s.x * s.y, yz = s.y * s.z, xz = s.x * s.z;
  return {1, s.y, s.z, s.x, xy, yz, 1, xz, 1, s.y, xy * s.z, s.y, s.z, s.x, s.z, s.x};
}

}  // namespace

void flip_axes(GaussianSet& set, const AxisSigns& s) {
  check(set.dim() == 3, "flip_axes: a static set");
  check(s.x * s.y * s.z == 1, "flip_axes: signs of a rotation");
  const GaussianSpans<float> values = set.values();
  const float mean[3] = {s.x, s.y, s.z};
  const float rotation[4] = {1, s.y * s.z, s.x * s.z, s.x * s.y};
  const auto sh = sh_signs(s);
  for (int64_t n = 0; n < set.count(); ++n) {
    for (int k = 0; k < 3; ++k) values.at(kMean, n)[k] *= mean[k];
    for (int k = 0; k < 4; ++k) values.at(kRotation, n)[k] *= rotation[k];
    for (int i = 1; i < set.coefficients(); ++i)
      for (int c = 0; c < 3; ++c) values.at(kSh, n)[3 * i + c] *= sh[size_t(i)];
  }
}

}  // namespace tessera
