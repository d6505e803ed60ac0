// What: the exposure of an image: its gain on one colour channel, before the loss, and backward.
// Not: whose gain it is, nor what the gains of all images must satisfy
// (recon4d/model/exposure.h). Source: x = e·c, failure mode B10.
#pragma once
#include "kernels/math/scalar.h"

namespace tessera {

/// dL/dc and what one pixel adds to dL/de, for x = e·c.
template <class Real>
struct GainGradient {
  Real colour, gain;
};

template <class Real>
TESSERA_HD inline GainGradient<Real> gain_backward(Real gain, Real colour, Real d_x) {
  return {gain * d_x, colour * d_x};
}

/// By how much a pixel of that colour, seen with that gain, misses its truth in [0, 1].
template <class Real>
TESSERA_HD inline Real gained_residual(Real gain, Real colour, Real truth) {
  return gain * colour - truth;
}

}  // namespace tessera
