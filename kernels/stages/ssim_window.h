// Convolution of a plane with the separable SSIM window, with zero or reflected borders. The loss
// and the metrics share it.
#pragma once
#include <vector>

#include "kernels/math/photometric.h"

namespace tessera {

/// Outside the image: zeros (training loss, 3DGS metrics) or mirror without repeating the edge
/// (torchmetrics); reflection needs width and height > kSsimRadius.
enum class Padding { kZero, kReflect };

/// Index of sample i of a line of `count` samples, or −1 for a zero.
inline int padded_index(int i, int count, Padding padding) {
  if (i >= 0 && i < count) return i;
  if (padding == Padding::kZero) return -1;
  return i < 0 ? -i : 2 * (count - 1) - i;
}

template <class Real>
void convolve_rows(const Real* in, int width, int height, Padding padding, Real* out) {
  std::vector<Real> line(size_t(width) + 2 * kSsimRadius, Real(0));
  Real* const first = line.data() + kSsimRadius;  // sample 0 of the line
  for (int y = 0; y < height; ++y) {
    const Real* from = in + int64_t(y) * width;
    for (int x = 0; x < width; ++x) first[x] = from[x];
    if (padding == Padding::kReflect)
      for (int k = 1; k <= kSsimRadius; ++k) {
        first[-k] = from[k];
        first[width - 1 + k] = from[width - 1 - k];
      }
    Real* to = out + int64_t(y) * width;
    const Real* padded = line.data();
    for (int x = 0; x < width; ++x) {
      Real sum = Real(0);
      for (int k = 0; k < kSsimTaps; ++k) sum += kSsimWindow<Real>[k] * padded[x + k];
      to[x] = sum;
    }
  }
}

template <class Real>
void convolve_columns(const Real* in, int width, int height, Padding padding, Real* out) {
  for (int y = 0; y < height; ++y) {
    Real* to = out + int64_t(y) * width;
    for (int x = 0; x < width; ++x) to[x] = Real(0);
    for (int k = 0; k < kSsimTaps; ++k) {
      const int from_row = padded_index(y + k - kSsimRadius, height, padding);
      if (from_row < 0) continue;
      const Real tap = kSsimWindow<Real>[k];
      const Real* from = in + int64_t(from_row) * width;
      for (int x = 0; x < width; ++x) to[x] += tap * from[x];
    }
  }
}

/// in and out [height, width]; `scratch` of the same size; out may be in.
template <class Real>
void convolve(const Real* in, int width, int height, Padding padding, Real* scratch, Real* out) {
  convolve_rows(in, width, height, padding, scratch);
  convolve_columns(scratch, width, height, padding, out);
}

/// The four windowed moments of two planes.
template <class Real>
struct MomentPlanes {
  std::vector<Real> x, y, squares, xy, scratch;

  void compute(const Real* a, const Real* b, int width, int height, Padding padding) {
    const size_t pixels = size_t(width) * size_t(height);
    for (std::vector<Real>* plane : {&x, &y, &squares, &xy, &scratch}) plane->resize(pixels);
    for (size_t p = 0; p < pixels; ++p) {
      squares[p] = a[p] * a[p] + b[p] * b[p];
      xy[p] = a[p] * b[p];
    }
    convolve(a, width, height, padding, scratch.data(), x.data());
    convolve(b, width, height, padding, scratch.data(), y.data());
    for (std::vector<Real>* plane : {&squares, &xy})
      convolve(plane->data(), width, height, padding, scratch.data(), plane->data());
  }

  SsimMoments<Real> moments(size_t p) const { return {x[p], y[p], squares[p], xy[p]}; }
  SsimPoint<Real> point(size_t p) const { return ssim_point<Real>(moments(p)); }
};

}  // namespace tessera
