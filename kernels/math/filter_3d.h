// The 3D filter, which keeps Gaussians from being finer than the training views could sample: its
// size φ, the filtered scales and opacity with their gradient, and the changes of stored parameters
// in density control and at the end of a training. `smooth` acts where a set has its φ with it.
// Source: [Mip-Splatting], [Faster-GS]; method C.1.
#pragma once
#include "kernels/math/ewa.h"

namespace tessera {

/// Views sample what projects at most 15 % of the image outside of it  [Mip-Splatting].
template <class Real>
inline constexpr Real kFilterMargin = Real(0.15);

/// φ² = 0.2·(d/f)²  [Mip-Splatting].
template <class Real>
inline constexpr Real kFilterVariance = Real(0.2);

/// Whether a view sees a point well enough to sample it.
template <class Real>
TESSERA_HD inline bool samples(const ViewArgs<Real>& view, const Vec3<Real>& in_cam,
                               Real near_plane) {
  if (!(in_cam[2] >= near_plane)) return false;
  const Real x = view.fl_x * in_cam[0] / in_cam[2] + view.cx;
  const Real y = view.fl_y * in_cam[1] / in_cam[2] + view.cy;
  const Real mx = kFilterMargin<Real> * Real(view.width);
  const Real my = kFilterMargin<Real> * Real(view.height);
  return x >= -mx && x <= Real(view.width) + mx && y >= -my && y <= Real(view.height) + my;
}

/// ln s' and what came of s, o: s'² = s² + φ², o' = o·√(Π s²/Π s'²).
template <class Real>
struct Smoothed {
  Vec3<Real> log_scale;  // ln s'
  Real compensation;     // o'/o
};

template <class Real>
TESSERA_HD inline Smoothed<Real> smooth(const Vec3<Real>& log_scale, Real size) {
  Smoothed<Real> out;
  Real log_compensation = Real(0);
  for (int k = 0; k < 3; ++k) {
    out.log_scale[k] = Real(0.5) * log(exp(Real(2) * log_scale[k]) + size * size);
    log_compensation += log_scale[k] - out.log_scale[k];
  }
  out.compensation = exp(min_of(log_compensation, Real(0)));
  return out;
}

/// Through s' and o' to ln s: d_log_scale comes in by ln s' and leaves by ln s. `d_log_opacity`:
/// dL/do'·o'.
template <class Real>
TESSERA_HD inline void smooth_backward(const Vec3<Real>& log_smoothed, Real size,
                                       Real d_log_opacity, Vec3<Real>& d_log_scale) {
  for (int k = 0; k < 3; ++k) {
    const Real added = size * size * exp(Real(-2) * log_smoothed[k]);  // φ²/s'²
    d_log_scale[k] = d_log_scale[k] * (Real(1) - added) + d_log_opacity * added;
  }
}

/// What is done to the stored parameters of Gaussians because of their φ.
enum class FilterEdit {
  kRaiseScales,   // s ← max(s, φ)  [Faster-GS]
  kBake,          // s ← s', o ← o'
  kLimitOpacity,  // o ← min(o, limit/(o'/o)), so that o' ≤ limit
};

/// ln(o·c/(1 − o·c)) for o = σ(logit), 0 < c ≤ 1; 1 − o·c = (1 − o) + o·(1 − c) keeps its digits.
template <class Real>
TESSERA_HD inline Real logit_of_compensated(Real logit, Real c) {
  constexpr Real kLeast = Real(1e-37);  // a normal float
  const Real o = sigmoid(logit);
  return log(max_of(o * c, kLeast)) - log(max_of(sigmoid(-logit) + o * (Real(1) - c), kLeast));
}

}  // namespace tessera
