// Least squares over times of the clip, in double on the host.
#include "recon4d/motion/refit.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/base/cholesky.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using Matrix = std::vector<std::vector<double>>;  // by columns

/// Column k: the weights of control point k at evenly spread times.
Matrix design(int knots) {
  constexpr int kTimes = 401;
  Matrix columns(size_t(knots), std::vector<double>(kTimes, 0.0));
  for (int i = 0; i < kTimes; ++i) {
    const SplineWeights<double> s = spline_weights(double(i) / (kTimes - 1), knots);
    for (int k = 0; k < kSplineOrder; ++k) columns[size_t(s.first + k)][size_t(i)] = s.weight[k];
  }
  return columns;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// [old knots][knots]: what each old control point gives to the new ones.
Matrix conversion(int from, int to) {
  const Matrix before = design(from), after = design(to);
  std::vector<double> normal;
  for (const std::vector<double>& a : after)
    for (const std::vector<double>& b : after) normal.push_back(dot(a, b));
  const Cholesky equations(std::move(normal), after.size());
  Matrix shares;
  for (const std::vector<double>& old : before) {
    std::vector<double> right;
    for (const std::vector<double>& a : after) right.push_back(dot(a, old));
    shares.push_back(equations.solve(std::move(right)));
  }
  return shares;
}

/// [M, old knots, width] → [M, knots, width].
void convert(const Matrix& conversion, int64_t nodes, int width, ParameterGroup& group) {
  const auto knots = int64_t(conversion[0].size()), before = int64_t(conversion.size());
  Buffer<float> old;
  old.copy_from(group.value);
  Buffer<float> controls(nodes * knots * width);
  for (int64_t m = 0; m < nodes; ++m)
    for (int64_t i = 0; i < knots; ++i)
      for (int c = 0; c < width; ++c) {
        double sum = 0;
        for (int64_t j = 0; j < before; ++j)
          sum += conversion[size_t(j)][size_t(i)] * double(old[(m * before + j) * width + c]);
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
