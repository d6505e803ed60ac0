// The opacity and size with which n copies of a Gaussian look like the one that they replace, and
// the random choice of the Gaussians that are copied. Source: method B  [3DGS-MCMC], in double; the
// double sum of the source is collapsed.
#pragma once
#include "kernels/math/random.h"

namespace tessera {

/// More copies than this are counted as this many.
inline constexpr int kMostCopies = 50;
inline constexpr double kMostRelocatedOpacity = 1 - 0x1p-23;

/// What n copies have where one Gaussian was.
struct Relocated {
  double opacity;  // o' = 1 − (1 − o)^{1/n}: n of them over each other let as much light through
  double scale;    // f = s'/s
};

/// f = o / Σ_{k=1}^{n} C(n,k) (−1)^{k−1} o'^k/√k: the line integral through the centre of what n of
/// them show is that of the one. (The source's Σ_i Σ_k C(i−1,k) … collapses by Σ_i C(i−1,k) =
/// C(n,k+1).) The terms alternate and grow to (1 + o')^n, of which a sum of order 1 remains: with
/// o ≤ 1 − 2⁻²³ and n = 50 they reach 2e5, which leaves 11 digits in double and none in float.
TESSERA_HD inline Relocated relocated(double opacity, int copies) {
  const double o = opacity < kMostRelocatedOpacity ? opacity : kMostRelocatedOpacity;
  const int n = copies < kMostCopies ? copies : kMostCopies;
  const double each = -expm1(log1p(-o) / n);
  double term = -1, sum = 0;  // term: C(n,k) (−1)^{k−1} o'^k
  for (int k = 1; k <= n; ++k) {
    term *= -each * double(n - k + 1) / double(k);
    sum += term / sqrt(double(k));
  }
  return {each, o / sum};
}

/// Opacity as a whole number, so that sums do not depend on their order. Far from zero for what is
/// not dead.
TESSERA_HD inline int32_t draw_weight(double opacity) {
  return opacity > 0 ? int32_t(floor(opacity * 16777216.0 + 0.5)) : 0;
}

/// The Gaussian that element i copies: sums[n] = Σ_{m<n} weight_m, and the total at [count], which
/// is not 0.
TESSERA_HD inline int64_t drawn_source(const int64_t* sums, int64_t count, uint64_t seed,
                                       int64_t i) {
  const RandomBlock random = philox(seed, RandomStream::kRelocation, uint64_t(i));
  const int64_t place = int64_t(uniform_below(random, uint64_t(sums[count])));
  int64_t low = 0, high = count;  // sums[low] ≤ place < sums[high]
  while (high - low > 1) {
    const int64_t middle = low + (high - low) / 2;
    (sums[middle] <= place ? low : high) = middle;
  }
  return low;
}

}  // namespace tessera
