// What: worlds that differ by the signs of two axes: formats have conventions of their own.
// Not: general rotations (world_change.h).
// Source: formats 1.10.
#pragma once
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Signs of x, y and z, of which an even number are −1.
struct AxisSigns {
  float x, y, z;
};
inline constexpr AxisSigns kAsIs{1, 1, 1};
inline constexpr AxisSigns kRightUpBack{1, -1, -1};  // SPZ, three.js, of right-down-front
inline constexpr AxisSigns kLeftUpFront{-1, -1, 1};  // glTF as viewers have it

/// Means, quaternions, velocities and SH in the flipped world; its own inverse.
void flip_axes(GaussianSet& set, const AxisSigns& signs);

}  // namespace tessera
