// Colours that follow time: each SH coefficient is a cosine series around the temporal mean of the
// Gaussian, Σ_n cos(2πnΔ/T)·c_n with Δ = t − μ_t. The level n = 0 is the SH of every set; levels n
// ≥ 1 are stored by dynamic sets only. Source: 4D spherindrical harmonics  [Yang24]; method D.3.
#pragma once
#include "kernels/math/spherical_harmonics.h"

namespace tessera {

inline constexpr int kMaxTimeLevels = 2;

/// How colours follow from the coefficients of a set, the same for all views of a batch.
template <class Real>
struct ColourRules {
  int degree;             // bands that are evaluated
  int levels;             // n = 1 … levels are evaluated
  int row;                // 3K: scalars of a level as stored
  Real period;            // T, normalised time
  bool sliced_direction;  // RenderOptions::sliced_direction

  TESSERA_HD int scalars() const { return 3 * sh_coefficients(degree); }
};

/// cos(2πnΔ/T).
template <class Real>
TESSERA_HD inline Real level_weight(const ColourRules<Real>& rules, int n, Real delta) {
  return cos_turns(Real(n) * delta / rules.period);
}

/// dL/dc_nk of one colour channel, for Y_k at the viewing direction and the level's weight.
template <class Real>
TESSERA_HD inline Real sh_gradient(Real Y, Real weight, Real d_colour) {
  return weight * Y * d_colour;
}

/// d cos(2πnΔ/T)/dμ_t = 2πn/T·sin(2πnΔ/T), because dΔ/dμ_t = −1.
template <class Real>
TESSERA_HD inline Real level_slope(const ColourRules<Real>& rules, int n, Real delta) {
  return Real(n) * Real(kTurn) / rules.period * sin_turns(Real(n) * delta / rules.period);
}

/// Adds the levels to the coefficients that are evaluated; `time`: [L, K, 3].
template <class Real>
TESSERA_HD inline void add_levels(const ColourRules<Real>& rules, Real delta, const Real* time,
                                  Real* sh) {
  for (int n = 1; n <= rules.levels; ++n) {
    const Real weight = level_weight(rules, n, delta);
    const Real* const level = time + int64_t(n - 1) * rules.row;
    for (int j = 0; j < rules.scalars(); ++j) sh[j] += weight * level[j];
  }
}

/// ∂(un-clamped colour)/∂μ_t through the weights of the levels: Σ_n slope_n Σ_k Y_k c_nk.
template <class Real>
TESSERA_HD inline Vec3<Real> levels_slope(const ColourRules<Real>& rules, Real delta,
                                          const Real* time, const Vec3<Real>& direction) {
  Real Y[kMaxShCoefficients] = {};
  sh_basis(rules.degree, direction, Y);
  Vec3<Real> sum(Real(0));
  for (int n = 1; n <= rules.levels; ++n) {
    const Real* const level = time + int64_t(n - 1) * rules.row;
    Vec3<Real> along(Real(0));
    TESSERA_UNROLL
    for (int k = 0; k < kMaxShCoefficients; ++k) {
      if (k >= sh_coefficients(rules.degree)) break;
      for (int c = 0; c < 3; ++c) along[c] += Y[k] * level[3 * k + c];
    }
    sum += level_slope(rules, n, delta) * along;
  }
  return sum;
}

}  // namespace tessera
