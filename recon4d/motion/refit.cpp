// Least squares over times of the clip, in double on the host.
#include "recon4d/motion/refit.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using Matrix = std::vector<std::vector<double>>;

/// Rows of weights of all control points at evenly spread times.
Matrix design(int knots) {
  constexpr int kTimes = 401;
  Matrix rows(kTimes, std::vector<double>(size_t(knots), 0.0));
  for (int i = 0; i < kTimes; ++i) {
    const SplineWeights<double> s = spline_weights(double(i) / (kTimes - 1), knots);
    for (int k = 0; k < kSplineOrder; ++k) rows[size_t(i)][size_t(s.first + k)] = s.weight[k];
  }
  return rows;
}

/// Solves A X = B of a positive definite A by Gaussian elimination; X replaces B.
void solve(Matrix a, Matrix& b) {
  const size_t n = a.size();
  for (size_t i = 0; i < n; ++i)
    for (size_t r = i + 1; r < n; ++r) {
      const double f = a[r][i] / a[i][i];
      for (size_t c = i; c < n; ++c) a[r][c] -= f * a[i][c];
      for (size_t c = 0; c < b[r].size(); ++c) b[r][c] -= f * b[i][c];
    }
  for (size_t i = n; i-- > 0;)
    for (size_t c = 0; c < b[i].size(); ++c) {
      for (size_t k = i + 1; k < n; ++k) b[i][c] -= a[i][k] * b[k][c];
      b[i][c] /= a[i][i];
    }
}

/// transposed(a) · b.
Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out(a[0].size(), std::vector<double>(b[0].size(), 0.0));
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t r = 0; r < out.size(); ++r)
      for (size_t c = 0; c < out[r].size(); ++c) out[r][c] += a[i][r] * b[i][c];
  return out;
}

/// [knots, old knots]: new control points by old ones.
Matrix conversion(int from, int to) {
  const Matrix before = design(from), after = design(to);
  Matrix converted = product(after, before);
  solve(product(after, after), converted);
  return converted;
}

/// [M, old knots, width] → [M, knots, width].
void convert(const Matrix& conversion, int64_t nodes, int width, ParameterGroup& group) {
  const auto knots = int64_t(conversion.size()), before = int64_t(conversion[0].size());
  Buffer<float> old;
  old.copy_from(group.value);
  Buffer<float> controls(nodes * knots * width);
  for (int64_t m = 0; m < nodes; ++m)
    for (int64_t i = 0; i < knots; ++i)
      for (int c = 0; c < width; ++c) {
        double sum = 0;
        for (int64_t j = 0; j < before; ++j)
          sum += conversion[size_t(i)][size_t(j)] * double(old[(m * before + j) * width + c]);
        controls[(m * knots + i) * width + c] = float(sum);
      }
  group.value.copy_from(controls);
}

void zero(ParameterGroup& group) {
  Buffer<float> zeros(group.value.size());
  std::fill(zeros.begin(), zeros.end(), 0.0f);
  group.moment1.copy_from(zeros);
  group.moment2.copy_from(zeros);
}

}  // namespace

void refit_nodes(int knots, int64_t step, MotionNodes& nodes) {
  check(knots >= nodes.knots && !nodes.empty(), "refit_nodes: to more control points");
  const Matrix by_old = conversion(nodes.knots, knots);
  convert(by_old, nodes.count, 3, nodes.translation);
  convert(by_old, nodes.count, 4, nodes.rotation);
  for (ParameterGroup* const group : nodes.groups()) zero(*group);
  nodes.knots = knots;
  nodes.refitted = step;
}

}  // namespace tessera
