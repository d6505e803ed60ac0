// Where several cameras miss something at one timestep: pixels whose residual does not vanish in
// the mean of their neighbours, and the places on which cameras agree. The rays of several cameras
// that miss one thing meet where it is. Source: the constants gave the best worst timestep of a
// rendered rig of 13 cameras.
#pragma once
#include <cmath>
#include <cstdint>

#include "kernels/math/ewa.h"
#include "kernels/math/photometric.h"

namespace tessera {

/// The mean residual of the 3 × 3 pixels around a missed one is above this in some channel.
template <class Real>
inline constexpr Real kMissedResidual = Real(0.06);
/// So many cameras, and so many tenths of those that see a place, must miss it.
inline constexpr int kMissingCameras = 3, kMissingTenths = 7;

/// How much pixel (x, y) is missed: 255 times that mean, in its largest channel, at most 255; 0:
/// not at all. `residual` [3, height, width].
template <class Real>
TESSERA_HD inline uint8_t missed_level(const Real* residual, int width, int height, int x, int y) {
  const int64_t pixels = int64_t(width) * height;
  Real largest = Real(0);
  for (int c = 0; c < 3; ++c) {
    Real sum = Real(0);
    int count = 0;
    for (int v = max_of(0, y - 1); v <= min_of(height - 1, y + 1); ++v)
      for (int u = max_of(0, x - 1); u <= min_of(width - 1, x + 1); ++u, ++count)
        sum += residual[c * pixels + int64_t(v) * width + u];
    largest = max_of(largest, std::abs(sum) / Real(count));
  }
  if (!(largest > kMissedResidual<Real>)) return 0;
  return uint8_t(min_of(Real(255), Real(255) * largest));
}

/// Places of a box, cubes side by side; x runs fastest.
template <class Real>
struct VoteGrid {
  Vec3<Real> first{0};  // centre of place 0, world units
  Real side = Real(0);  // of a cube, world units
  int size[3] = {0, 0, 0};

  TESSERA_HD int64_t places() const { return int64_t(size[0]) * size[1] * size[2]; }
  TESSERA_HD Vec3<Real> centre(int64_t place) const {
    const int64_t x = place % size[0], y = place / size[0] % size[1], z = place / size[0] / size[1];
    return first + side * Vec3<Real>(Real(x), Real(y), Real(z));
  }
};

/// The pixel of a view in which a point lies; −1: in none.
template <class Real>
TESSERA_HD inline int64_t pixel_of(const ViewArgs<Real>& view, const Vec3<Real>& point, Real near) {
  const Vec3<Real> in_cam = view.cam_from_world * point + view.translation;
  if (!(in_cam[2] > near)) return -1;
  const Real x = view.fl_x * in_cam[0] / in_cam[2] + view.cx;
  const Real y = view.fl_y * in_cam[1] / in_cam[2] + view.cy;
  if (!(x >= Real(0) && x < Real(view.width) && y >= Real(0) && y < Real(view.height))) return -1;
  return int64_t(y) * view.width + int64_t(x);
}

/// Mean level, in [0, 1], of the views that miss a place, where these are enough; else 0. `missed`:
/// levels of the pixels of all views.
template <class Real>
TESSERA_HD inline Real residual_vote(const VoteGrid<Real>& grid, int64_t place,
                                     const ViewArgs<Real>* views, int count,
                                     const uint8_t* missed) {
  const Vec3<Real> centre = grid.centre(place);
  const int most = count * (10 - kMissingTenths) / 10;  // that may see nothing amiss
  int missing = 0, content = 0, sum = 0;
  for (int b = 0; b < count; ++b) {
    const int64_t pixel = pixel_of(views[b], centre, grid.side);
    if (pixel < 0) continue;
    const int level = missed[views[b].first_pixel + pixel];
    sum += level;
    if (level > 0)
      ++missing;
    else if (++content > most)
      return Real(0);
  }
  if (missing < kMissingCameras || 10 * missing < kMissingTenths * (missing + content))
    return Real(0);
  return Real(sum) / Real(255 * missing);
}

}  // namespace tessera
