// Reads the SH coefficients of one Gaussian into the registers of one thread.
#pragma once
#include "kernels/math/splat.h"

namespace tessera {

/// Calls visit(j, scalar j) for the coefficients of one level, read sixteen bytes at a time where
/// rows allow it.
template <class Visit>
__device__ inline void visit_sh(const float* from, int row, int wanted, Visit&& visit) {
  if (row % 4 == 0) {
    TESSERA_UNROLL
    for (int j = 0; j < 3 * kMaxShCoefficients; j += 4) {
      if (j >= wanted) break;
      const float4 four = *reinterpret_cast<const float4*>(from + j);
      visit(j, four.x);
      visit(j + 1, four.y);
      visit(j + 2, four.z);
      visit(j + 3, four.w);
    }
  } else {
    TESSERA_UNROLL
    for (int j = 0; j < 3 * kMaxShCoefficients; ++j)
      if (j < wanted) visit(j, from[j]);
  }
}

/// The coefficients of g at a time, as sh_at computes them.
__device__ inline void load_sh(const ColourRules<float>& rules, const GaussianState<float>& g,
                               float delta, float* sh) {
  visit_sh(g.sh, rules.row, rules.scalars(), [&](int j, float c) { sh[j] = c; });
  for (int n = 1; n <= rules.levels; ++n) {
    const float weight = level_weight(rules, n, delta);
    visit_sh(g.sh_time + int64_t(n - 1) * rules.row, rules.row, rules.scalars(),
             [&](int j, float c) { sh[j] += weight * c; });
  }
}

/// Rules in a kernel of one form: what a static set does not have is known when it is compiled.
template <SetForm form>
__device__ inline ColourRules<float> rules_of(ColourRules<float> rules) {
  if constexpr (!is_dynamic(form)) rules.levels = 0;
  return rules;
}

}  // namespace tessera
