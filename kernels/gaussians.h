// What: the parameters of a set of Gaussians as kernels see them: named groups of spans.
// Not: an owner (recon4d/gaussian_set.h), and no schedule or learning rate.
#pragma once
#include <cstdint>

#include "kernels/base/span.h"
#include "kernels/math/adam.h"

namespace tessera {

/// Parameter groups in storage order. Dim 3 sets have the first kStaticGroups only.
enum Group : int {
  kMean,           // [N, 3] world units
  kLogScale,       // [N, 3] ln of world units
  kRotation,       // [N, 4] quaternion w,x,y,z; Dim 4: the left one
  kOpacityLogit,   // [N]
  kSh,             // [N, K, 3] spherical harmonics, RGB innermost
  kMeanTime,       // [N] normalised time
  kLogScaleTime,   // [N] ln of normalised time
  kRotationRight,  // [N, 4]
  kGroupCount
};
inline constexpr int kStaticGroups = 5;

inline constexpr int group_count(int dim) {
  return dim == 4 ? kGroupCount : kStaticGroups;
}

/// The stored name: `rotation` is `rotation_left` in a Dim 4 set.
inline const char* group_name(Group group, int dim) {
  constexpr const char* kNames[kGroupCount] = {
      "mean", "log_scale", "rotation",       "opacity_logit",
      "sh",   "mean_time", "log_scale_time", "rotation_right"};
  return dim == 4 && group == kRotation ? "rotation_left" : kNames[group];
}

/// Scalars per Gaussian of a group; `coefficients` = K.
TESSERA_HD inline constexpr int group_width(Group group, int coefficients) {
  switch (group) {
    case kMean:
    case kLogScale:
      return 3;
    case kRotation:
    case kRotationRight:
      return 4;
    case kSh:
      return 3 * coefficients;
    default:
      return 1;
  }
}

template <class T>
struct GaussianSpans {
  int dim = 3;            // 3: static, 4: dynamic
  int64_t count = 0;      // N
  int coefficients = 16;  // K
  Span<T> group[kGroupCount];

  /// First scalar of Gaussian n in a group.
  TESSERA_HD T* at(Group g, int64_t n) const {
    return group[g].data + n * group_width(g, coefficients);
  }
};

/// Step sizes of every group; the first SH coefficient has its own.
template <class Real>
struct AdamGroups {
  AdamScalars<Real> group[kGroupCount];  // kSh: coefficient 0
  AdamScalars<Real> sh_rest;             // coefficients 1 … K−1
};

/// Where a set's gradients go. With `fused` they are consumed by Adam where they arise.
template <class Real>
struct SinkArgs {
  bool fused = false;
  GaussianSpans<Real> gradient;                 // StoreGradient: written, not added to
  GaussianSpans<Real> value, moment1, moment2;  // ApplyAdam
  AdamGroups<Real> adam;                        // ApplyAdam
};

/// Densification statistic of a set, accumulated over batches  [method D.6].
template <class Real>
struct DensityStatistics {
  Span<Real> gradient_sum;  // [N] Σ over batches of the mean over views of ‖dL/d mean2D‖ in NDC
  Span<Real> count;         // [N] batches in which it was visible
};

}  // namespace tessera
