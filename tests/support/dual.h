// Dual, a forward-mode derivative number with which the headers of kernels/math are instantiated,
// and the gradient of a scalar function by one pass per input. Source: value + ε·derivative with ε²
// = 0, which gives exact derivatives without a step size.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tessera::testing {

struct Dual {
  double value, d;

  // trivial, because glm keeps its components in unions
  Dual() = default;
  constexpr Dual(double v) : value(v), d(0) {}
  constexpr Dual(double v, double derivative) : value(v), d(derivative) {}

  friend constexpr Dual operator-(Dual a) { return {-a.value, -a.d}; }
  friend constexpr Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.d + b.d}; }
  friend constexpr Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.d - b.d}; }
  friend constexpr Dual operator*(Dual a, Dual b) {
    return {a.value * b.value, a.d * b.value + a.value * b.d};
  }
  friend constexpr Dual operator/(Dual a, Dual b) {
    return {a.value / b.value, (a.d * b.value - a.value * b.d) / (b.value * b.value)};
  }
  constexpr Dual& operator+=(Dual o) { return *this = *this + o; }
  constexpr Dual& operator-=(Dual o) { return *this = *this - o; }
  constexpr Dual& operator*=(Dual o) { return *this = *this * o; }
  constexpr Dual& operator/=(Dual o) { return *this = *this / o; }

  friend constexpr bool operator==(Dual a, Dual b) { return a.value == b.value; }
  friend constexpr bool operator<(Dual a, Dual b) { return a.value < b.value; }
  friend constexpr bool operator>(Dual a, Dual b) { return a.value > b.value; }
  friend constexpr bool operator<=(Dual a, Dual b) { return a.value <= b.value; }
  friend constexpr bool operator>=(Dual a, Dual b) { return a.value >= b.value; }
};

// found by argument-dependent look-up from the equations
inline Dual exp(Dual a) {
  return {std::exp(a.value), std::exp(a.value) * a.d};
}
inline Dual fast_exp(Dual a) {
  return exp(a);
}
inline Dual log(Dual a) {
  return {std::log(a.value), a.d / a.value};
}
inline Dual sqrt(Dual a) {
  return {std::sqrt(a.value), a.d / (2 * std::sqrt(a.value))};
}

/// ∂f/∂x_i for every i; `f` takes std::array<Dual, N> and returns a Dual.
template <size_t N, class Function>
std::array<double, N> dual_gradient(const std::array<double, N>& x, Function&& f) {
  std::array<double, N> gradient{};
  for (size_t i = 0; i < N; ++i) {
    std::array<Dual, N> d;
    for (size_t j = 0; j < N; ++j) d[j] = Dual(x[j], i == j ? 1.0 : 0.0);
    gradient[i] = f(d).d;
  }
  return gradient;
}

}  // namespace tessera::testing

// glm requires these of a scalar
template <>
class std::numeric_limits<tessera::testing::Dual> : public std::numeric_limits<double> {};
