// Small dense systems of equations with a symmetric positive definite matrix.
#pragma once
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace tessera {

/// A = L Lᵀ, with L in the lower triangle, row-major.
class Cholesky {
 public:
  /// `a`: [n, n] row-major, symmetric and positive definite.
  Cholesky(std::vector<double> a, size_t n) : l_(std::move(a)), n_(n) {
    for (size_t j = 0; j < n; ++j) {
      for (size_t k = 0; k < j; ++k) l_[j * n + j] -= l_[j * n + k] * l_[j * n + k];
      l_[j * n + j] = std::sqrt(l_[j * n + j]);
      for (size_t i = j + 1; i < n; ++i) {
        for (size_t k = 0; k < j; ++k) l_[i * n + j] -= l_[i * n + k] * l_[j * n + k];
        l_[i * n + j] /= l_[j * n + j];
      }
    }
  }

  /// x of A x = b; `b`: [n].
  std::vector<double> solve(std::vector<double> b) const {
    for (size_t i = 0; i < n_; ++i) {
      for (size_t k = 0; k < i; ++k) b[i] -= l_[i * n_ + k] * b[k];
      b[i] /= l_[i * n_ + i];
    }
    for (size_t i = n_; i-- > 0;) {
      for (size_t k = i + 1; k < n_; ++k) b[i] -= l_[k * n_ + i] * b[k];
      b[i] /= l_[i * n_ + i];
    }
    return b;
  }

 private:
  std::vector<double> l_;
  size_t n_;
};

}  // namespace tessera
