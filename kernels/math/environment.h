// Radiance at infinity behind all Gaussians: a map of directions, and the texels under a pixel.
// Deviation: the code of [Yang24] uses a sphere of radius 60; a map at infinity has no parallax and
// does not depend on the scale of the world. Source: method D.8.
#pragma once
#include "kernels/math/ewa.h"

namespace tessera {

/// Row 0 of a map looks to +z, the last to −z; columns go round from −x over −y, +x, +y.
inline constexpr int kEnvironmentAspect = 2;  // columns by rows

using std::atan2;
using std::floor;

inline int64_t environment_scalars(int64_t height) {
  return 3 * kEnvironmentAspect * height * height;
}

/// Four texels, row · width + column, and their shares of a direction; these sum to 1.
template <class Real>
struct EnvironmentTap {
  int64_t texel[4];
  Real share[4];
};

/// Bilinear between centres of texels: the map closes in longitude and is clamped at the poles.
/// `d` of any length > 0.
template <class Real>
TESSERA_HD inline EnvironmentTap<Real> environment_tap(const Vec3<Real>& d, int height) {
  const int width = kEnvironmentAspect * height;
  const Real pi = Real(3.14159265358979323846);
  const Real across = sqrt(d[0] * d[0] + d[1] * d[1]);
  const Real u = (atan2(d[1], d[0]) / (Real(2) * pi) + Real(0.5)) * Real(width) - Real(0.5);
  const Real v =
      clamp_to(atan2(across, d[2]) / pi * Real(height) - Real(0.5), Real(0), Real(height - 1));
  const Real left = floor(u), above = floor(v);
  const int x0 = (int(left) + width) % width, x1 = (x0 + 1) % width;
  const int y0 = int(above), y1 = min_of(y0 + 1, height - 1);
  const Real s = u - left, t = v - above;
  return {{int64_t(y0) * width + x0, int64_t(y0) * width + x1, int64_t(y1) * width + x0,
           int64_t(y1) * width + x1},
          {(Real(1) - s) * (Real(1) - t), s * (Real(1) - t), (Real(1) - s) * t, s * t}};
}

/// What the centre of pixel (x, y) looks along, in the world; not of length 1.
template <class Real>
TESSERA_HD inline Vec3<Real> pixel_direction(const ViewArgs<Real>& view, int x, int y) {
  const Vec3<Real> in_cam((Real(x) + Real(0.5) - view.cx) / view.fl_x,
                          (Real(y) + Real(0.5) - view.cy) / view.fl_y, Real(1));
  return glm::transpose(view.cam_from_world) * in_cam;
}

/// E of one channel.
template <class Real>
TESSERA_HD inline Real environment_value(const EnvironmentTap<Real>& tap, const Real* map,
                                         int channel) {
  Real value = Real(0);
  for (int k = 0; k < 4; ++k) value += tap.share[k] * map[3 * tap.texel[k] + channel];
  return value;
}

}  // namespace tessera
