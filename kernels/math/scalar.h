// The scalar functions that equations call, for float, double and (in tests) dual numbers. Fast
// math is not used globally: an approximation has a name such as `fast_exp`.
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/base/host_device.h"

namespace tessera {

using std::exp;
using std::log;
using std::sqrt;

template <class Real>
TESSERA_HD inline Real min_of(Real a, Real b) {
  return a < b ? a : b;
}
template <class Real>
TESSERA_HD inline Real max_of(Real a, Real b) {
  return a > b ? a : b;
}
template <class Real>
TESSERA_HD inline Real abs_of(Real a) {
  return a < Real(0) ? -a : a;
}
template <class Real>
TESSERA_HD inline Real clamp_to(Real value, Real low, Real high) {
  return value < low ? low : (value > high ? high : value);
}

/// exp(x) for x ≤ 0, as blending needs it: relative error < 2e-7 down to x = −87, 0-ish below.
/// Branch-free so that loops over pixels vectorise. exp(x) = 2^n·e^r, r = x − n·ln2, |r| ≤ ln2/2;
/// the polynomial is the Taylor series of e^r to degree 7, evaluated in Horner form.
TESSERA_HD inline float fast_exp(float x) {
#if defined(__CUDA_ARCH__)
  return __expf(x);  // the device has an instruction of about that accuracy
#else
  constexpr float kLog2E = 1.44269504f;
  constexpr float kLn2High = 0.693359375f, kLn2Low = -2.12194440e-4f;  // high part is exact · n
  constexpr float kRound = 12582912.0f;  // 1.5·2^23: adding it rounds to an integer
  x = x < -87.0f ? -87.0f : x;           // 2^n stays a normal number
  const float shifted = x * kLog2E + kRound;
  const float n = shifted - kRound;
  const float r = (x - n * kLn2High) - n * kLn2Low;
  float e = 1.0f / 5040;
  e = e * r + 1.0f / 720;
  e = e * r + 1.0f / 120;
  e = e * r + 1.0f / 24;
  e = e * r + 1.0f / 6;
  e = e * r + 0.5f;
  e = e * r + 1.0f;
  e = e * r + 1.0f;
  const int32_t exponent = (std::bit_cast<int32_t>(shifted) - std::bit_cast<int32_t>(kRound)) << 23;
  return std::bit_cast<float>(std::bit_cast<int32_t>(e) + exponent);
#endif
}
/// In double, where accuracy is the point, it is the library's.
TESSERA_HD inline double fast_exp(double x) {
  return exp(x);
}

/// a / b where a rounding or two do not matter; b less than the least normal number counts as 0.
template <class Real>
TESSERA_HD inline Real fast_divide(Real a, Real b) {
#if defined(__CUDA_ARCH__)
  if constexpr (sizeof(Real) == sizeof(float)) {
    // the product in C++: one inside of assembly may be contracted with what comes next, in one
    // kernel and not in the other
    float reciprocal;
    asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(reciprocal) : "f"(b));
    return a * reciprocal;
  }
#endif
  return a / b;
}

/// √x where a rounding or two do not matter; of less than the least normal number 0.
template <class Real>
TESSERA_HD inline Real fast_sqrt(Real x) {
#if defined(__CUDA_ARCH__)
  if constexpr (sizeof(Real) == sizeof(float)) {
    float root;
    asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(root) : "f"(x));
    return root;
  }
#endif
  return sqrt(x);
}

inline constexpr double kTurn = 6.283185307179586;  // 2π

/// cos(2πx). Whole turns are taken off first, which is exact; the device's function does so itself.
template <class Real>
TESSERA_HD inline Real cos_turns(Real x) {
#if defined(__CUDA_ARCH__)
  if constexpr (sizeof(Real) == sizeof(float)) return ::cospif(2 * x);
#endif
  return std::cos(Real(kTurn) * (x - std::round(x)));
}
/// sin(2πx).
template <class Real>
TESSERA_HD inline Real sin_turns(Real x) {
#if defined(__CUDA_ARCH__)
  if constexpr (sizeof(Real) == sizeof(float)) return ::sinpif(2 * x);
#endif
  return std::sin(Real(kTurn) * (x - std::round(x)));
}

template <class Real>
TESSERA_HD inline Real sigmoid(Real x) {
  return Real(1) / (Real(1) + exp(-x));
}

/// Of an opacity in (0, 1).
inline float logit(double p) {
  return float(std::log(p / (1 - p)));
}

}  // namespace tessera
