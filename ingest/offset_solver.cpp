// What: robust least squares on the graph of pairs, and on the misses of one pair.
// Not: media.
#include "ingest/offset_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tessera {
namespace {

constexpr double kCauchy = 2.385;  // 95 % efficient where errors are normal

double cauchy_weight(double error, double sigma) {
  const double e = error / (kCauchy * sigma);
  return 1 / (1 + e * e);
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Which clocks the pairs connect with the largest group.
std::vector<bool> largest_group(int count, const std::vector<PairOffset>& pairs) {
  std::vector<int> group(static_cast<size_t>(count));
  std::iota(group.begin(), group.end(), 0);
  for (const PairOffset& pair : pairs) {
    const int from = group[size_t(pair.b)], to = group[size_t(pair.a)];
    std::replace(group.begin(), group.end(), from, to);
  }
  int best = 0;
  int64_t most = 0;
  for (const int candidate : group)
    if (const int64_t n = std::count(group.begin(), group.end(), candidate); n > most)
      most = n, best = candidate;
  std::vector<bool> inside;
  for (const int g : group) inside.push_back(most > 1 && g == best);
  return inside;
}

using Table = std::vector<std::vector<double>>;

/// Inverse of a symmetric positive matrix by Gauss and Jordan.
Table inverse(Table m) {
  const size_t n = m.size();
  Table result(n, std::vector<double>(n));
  for (size_t i = 0; i < n; ++i) result[i][i] = 1;
  for (size_t column = 0; column < n; ++column) {
    const double pivot = m[column][column];
    for (size_t k = 0; k < n; ++k) m[column][k] /= pivot, result[column][k] /= pivot;
    for (size_t row = 0; row < n; ++row) {
      if (row == column) continue;
      const double factor = m[row][column];
      for (size_t k = 0; k < n; ++k) {
        m[row][k] -= factor * m[column][k];
        result[row][k] -= factor * result[column][k];
      }
    }
  }
  return result;
}

/// Covariance of offsets whose mean is held at 0 (the weak spring on the mean fixes the gauge and
/// touches no difference), and the offsets themselves.
Table solve_weighted(const std::vector<PairOffset>& pairs, const std::vector<double>& weights,
                     const std::vector<bool>& inside, std::vector<double>& offsets) {
  const size_t n = inside.size();
  const double spring = *std::max_element(weights.begin(), weights.end());
  Table normal(n, std::vector<double>(n));
  std::vector<double> right(n);
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j)
      if (inside[i] && inside[j]) normal[i][j] = spring;
  for (size_t i = 0; i < n; ++i)
    if (!inside[i]) normal[i][i] = 1;
  for (size_t p = 0; p < pairs.size(); ++p) {
    const size_t a = size_t(pairs[p].a), b = size_t(pairs[p].b);
    if (!inside[a]) continue;
    normal[a][a] += weights[p], normal[b][b] += weights[p];
    normal[a][b] -= weights[p], normal[b][a] -= weights[p];
    right[b] += weights[p] * pairs[p].offset, right[a] -= weights[p] * pairs[p].offset;
  }
  Table covariance = inverse(std::move(normal));
  const double group = double(std::count(inside.begin(), inside.end(), true));
  for (size_t i = 0; i < n; ++i)
    offsets[i] = std::inner_product(right.begin(), right.end(), covariance[i].begin(), 0.0);
  for (size_t i = 0; i < n; ++i)
    covariance[i][i] -= 1 / (spring * group * group);  // the mean's own
  return covariance;
}

}  // namespace

double median_offset(std::vector<double> offsets) {
  if (offsets.empty()) return 0;
  const auto middle = offsets.begin() + std::ptrdiff_t((offsets.size() - 1) / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

std::vector<SolvedOffset> solve_offsets(int count, const std::vector<PairOffset>& pairs) {
  constexpr int kRounds = 30;
  std::vector<SolvedOffset> solved(static_cast<size_t>(count));
  if (pairs.empty()) return solved;
  const std::vector<bool> inside = largest_group(count, pairs);
  std::vector<double> offsets(solved.size()), weights;
  for (const PairOffset& pair : pairs) weights.push_back(1 / (pair.sigma * pair.sigma));
  Table covariance;
  double spread = 1;  // how much worse the pairs agree than their errors say
  for (int round = 0; round < kRounds; ++round) {
    covariance = solve_weighted(pairs, weights, inside, offsets);
    std::vector<double> misfit;
    for (const PairOffset& pair : pairs)
      misfit.push_back(pair.offset - (offsets[size_t(pair.b)] - offsets[size_t(pair.a)]));
    std::vector<double> relative;
    for (size_t p = 0; p < pairs.size(); ++p)
      relative.push_back(std::abs(misfit[p]) / pairs[p].sigma);
    spread = std::max(1.0, 1.4826 * median_of(relative));
    for (size_t p = 0; p < pairs.size(); ++p)
      weights[p] =
          cauchy_weight(misfit[p], spread * pairs[p].sigma) / (pairs[p].sigma * pairs[p].sigma);
  }
  std::vector<double> known;
  for (size_t i = 0; i < solved.size(); ++i)
    if (inside[i]) known.push_back(offsets[i]);
  const double middle = median_offset(known);
  for (size_t i = 0; i < solved.size(); ++i)
    if (inside[i])
      solved[i] = {offsets[i] - middle, spread * std::sqrt(std::max(0.0, covariance[i][i])), true};
  return solved;
}

std::optional<PairShift> shift_from_misses(const std::vector<EpipolarMiss>& misses, double reach,
                                           double frame_seconds) {
  constexpr double kPixels = 1;       // within which a miss agrees while the shift is sought
  constexpr double kSlowest = 0.2;    // pixels a frame; slower points say nothing of time
  constexpr size_t kFewest = 24;      // points that agree: 12 a parameter of a line, doubled
  constexpr double kCorrelation = 3;  // a texture's error lasts about nine frames: √9
  std::vector<EpipolarMiss> moving;
  for (const EpipolarMiss& m : misses)
    if (std::abs(m.slope) * frame_seconds > kSlowest) moving.push_back(m);
  if (moving.size() < kFewest) return std::nullopt;
  double best = -1, shift = 0;
  const double step = 0.05 * frame_seconds;
  for (int i = -int(reach / step); i <= int(reach / step); ++i) {
    double votes = 0;
    for (const EpipolarMiss& m : moving)
      votes += cauchy_weight(m.miss - m.slope * i * step, kPixels);
    if (votes > best || (votes == best && std::abs(i * step) < std::abs(shift)))
      best = votes, shift = i * step;
  }
  double information = 0, sigma = kPixels;
  size_t support = 0;
  for (int round = 0; round < 20; ++round) {
    double up = 0, down = 0;
    information = 0, support = 0;
    std::vector<double> near;
    for (const EpipolarMiss& m : moving) {
      const double error = m.miss - m.slope * shift, weight = cauchy_weight(error, sigma);
      up += weight * m.slope * error, down += weight * m.slope * m.slope;
      information += weight * m.slope * m.slope;
      if (std::abs(error) < 3 * kPixels) near.push_back(std::abs(error));
      support += std::abs(error) < kPixels ? 1 : 0;
    }
    if (near.size() < kFewest) return std::nullopt;
    shift += up / down;
    sigma = std::clamp(1.4826 * median_of(near), 0.05, kPixels);
  }
  // where fewer than a third agree, the matches are mostly wrong and any shift would do
  if (support < kFewest || 3 * support < moving.size() || std::abs(shift) > reach)
    return std::nullopt;
  return PairShift{shift, kCorrelation * sigma / std::sqrt(information), support};
}

}  // namespace tessera
