// What: the streams that hold spherical harmonics: one for each degree.
// Not: their numbers (block.h).
// Source: docs/reference/tessera4d.md, section 4.
#pragma once
#include "kernels/math/spherical_harmonics.h"

namespace tessera {

inline constexpr const char* kShNames[kMaxShDegree + 1] = {"colour", "sh1", "sh2", "sh3"};

/// Scalars of a degree, three channels; where they begin in a row.
inline int band_width(int degree) {
  return 3 * (2 * degree + 1);
}
inline int band_begin(int degree) {
  return degree == 0 ? 0 : 3 * sh_coefficients(degree - 1);
}

}  // namespace tessera
