// The colour of a camera: an affine map of the rendered image before the loss, and its gradient.
// Whose map it is, and what the maps of all cameras must satisfy: recon4d/model/exposure.h.
// Source: x = A·c + o; failure mode B10.
#pragma once
#include <cstdint>

#include "kernels/math/symmetric.h"

namespace tessera {

/// x = matrix·c + offset of a linear RGB colour in [0, 1]. As a gradient: dL/dA and dL/do.
template <class Real>
struct ColourMap {
  Mat3<Real> matrix{1};
  Vec3<Real> offset{0};

  TESSERA_HD Vec3<Real> operator()(const Vec3<Real>& colour) const {
    return Vec3<Real>(dot(row(matrix, 0), colour) + offset[0],
                      dot(row(matrix, 1), colour) + offset[1],
                      dot(row(matrix, 2), colour) + offset[2]);
  }
  TESSERA_HD ColourMap& operator+=(const ColourMap& o) {
    matrix += o.matrix;
    offset += o.offset;
    return *this;
  }
  template <class Other>
  TESSERA_HD ColourMap<Other> as() const {
    return {Mat3<Other>(matrix), Vec3<Other>(offset)};
  }
};

/// A gain of each channel, without an offset.
template <class Real>
TESSERA_HD inline ColourMap<Real> colour_gain(const Vec3<Real>& gain) {
  ColourMap<Real> map;
  for (int c = 0; c < 3; ++c) map.matrix[c][c] = gain[c];
  return map;
}

/// The colour of pixel p of a view whose channels lie `pixels` apart.
template <class Real>
TESSERA_HD inline Vec3<Real> planar_colour(const Real* view, int64_t pixels, int64_t p) {
  return Vec3<Real>(view[p], view[pixels + p], view[2 * pixels + p]);
}
template <class Real>
TESSERA_HD inline void set_planar_colour(Real* view, int64_t pixels, int64_t p,
                                         const Vec3<Real>& colour) {
  for (int c = 0; c < 3; ++c) view[c * pixels + p] = colour[c];
}

/// dL/dc = Aᵀ·dL/dx.
template <class Real>
TESSERA_HD inline Vec3<Real> through_colour_map(const ColourMap<Real>& map, const Vec3<Real>& d_x) {
  return Vec3<Real>(dot(map.matrix[0], d_x), dot(map.matrix[1], d_x), dot(map.matrix[2], d_x));
}

/// What one pixel adds to dL/dA = dL/dx·cᵀ and dL/do = dL/dx.
template <class Real>
TESSERA_HD inline ColourMap<Real> colour_map_gradient(const Vec3<Real>& colour,
                                                      const Vec3<Real>& d_x) {
  return {Mat3<Real>(colour[0] * d_x, colour[1] * d_x, colour[2] * d_x), d_x};
}

/// By how much a colour follows a change of its own channel: the diagonal of A. Deviation: what a
/// channel takes from the other two is left out where Gaussians are ranked by their removal.
template <class Real>
TESSERA_HD inline Vec3<Real> channel_response(const ColourMap<Real>& map) {
  return Vec3<Real>(map.matrix[0][0], map.matrix[1][1], map.matrix[2][2]);
}

}  // namespace tessera
