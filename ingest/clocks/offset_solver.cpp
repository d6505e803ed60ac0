// Robust least squares on the graph of pairs of clocks, and on the correspondences of one pair.
#include "ingest/clocks/offset_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/base/cholesky.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr double kCauchy = 2.385;  // 95 % efficient where errors are normal

double cauchy_weight(double error, double sigma) {
  const double e = error / (kCauchy * sigma);
  return 1 / (1 + e * e);
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
    if (const int64_t n = std::count(group.begin(), group.end(), candidate); n > most) {
      most = n;
      best = candidate;
    }
  std::vector<bool> inside;
  for (const int g : group) inside.push_back(most > 1 && g == best);
  return inside;
}

/// Variances of offsets whose mean is held at 0 (the weak spring on the mean fixes the gauge and
/// touches no difference), and the offsets themselves.
std::vector<double> solve_weighted(const std::vector<PairOffset>& pairs,
                                   const std::vector<double>& weights,
                                   const std::vector<bool>& inside, std::vector<double>& offsets) {
  const size_t n = inside.size();
  const double spring = *std::max_element(weights.begin(), weights.end());
  std::vector<double> normal(n * n), right(n), variances(n);
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j)
      if (inside[i] && inside[j]) normal[i * n + j] = spring;
  for (size_t i = 0; i < n; ++i)
    if (!inside[i]) normal[i * n + i] = 1;
  for (size_t p = 0; p < pairs.size(); ++p) {
    const size_t a = size_t(pairs[p].a), b = size_t(pairs[p].b);
    if (!inside[a]) continue;
    normal[a * n + a] += weights[p];
    normal[b * n + b] += weights[p];
    normal[a * n + b] -= weights[p];
    normal[b * n + a] -= weights[p];
    right[b] += weights[p] * pairs[p].offset;
    right[a] -= weights[p] * pairs[p].offset;
  }
  const Cholesky factor(std::move(normal), n);
  offsets = factor.solve(right);
  const double group = double(std::count(inside.begin(), inside.end(), true));
  for (size_t i = 0; i < n; ++i) {
    std::vector<double> unit(n);
    unit[i] = 1;
    variances[i] = factor.solve(std::move(unit))[i] - 1 / (spring * group * group);  // the mean's
  }
  return variances;
}

/// The part of the pairs' errors that is left in their residuals, as the others went into the
/// offsets; 1 where none is (every pair is needed): these do not tell the errors.
double shrunk_by(const std::vector<PairOffset>& pairs, const std::vector<bool>& inside) {
  double count = 0, unknowns = double(std::count(inside.begin(), inside.end(), true)) - 1;
  for (const PairOffset& pair : pairs) count += inside[size_t(pair.a)];
  return count > unknowns ? std::sqrt((count - unknowns) / count) : 1;
}

constexpr double kAgreeingPixels = 1;  // within which a miss agrees while the shift is sought
constexpr size_t kFewestMisses = 24;   // that agree: 12 a parameter of a line, doubled
constexpr double kCorrelation = 3;     // a texture's error lasts about nine frames: √9

double error_of(const EpipolarMiss& m, const PairShift& shift) {
  return m.miss - m.slope * (shift.shift + shift.rate * m.seconds);
}

/// The best of a grid of shifts and rates within ±reach and ±rate_reach.
PairShift most_votes(const std::vector<EpipolarMiss>& moving, double reach, double rate_reach,
                     double frame_seconds) {
  double longest = 0;
  for (const EpipolarMiss& m : moving) longest = std::max(longest, std::abs(m.seconds));
  const double step = 0.05 * frame_seconds;
  const double rate_step = 0.25 * frame_seconds / std::max(longest, frame_seconds);
  double best = -1;
  PairShift found;
  const int shifts = int(reach / step), rates = int(rate_reach / rate_step);
  for (int k = -rates; k <= rates; ++k)
    for (int i = -shifts; i <= shifts; ++i) {
      const PairShift shift{i * step, 0, 0, k * rate_step, 0};
      double votes = 0;
      for (const EpipolarMiss& m : moving)
        votes += cauchy_weight(error_of(m, shift), kAgreeingPixels);
      const double size = std::abs(shift.shift) + longest * std::abs(shift.rate);
      const double least = std::abs(found.shift) + longest * std::abs(found.rate);
      if (votes > best || (votes == best && size < least)) {
        best = votes;
        found = shift;
      }
    }
  return found;
}

/// The normal equations of a shift s and its rate r.
struct ShiftEquations {
  double ss = 0, sr = 0, rr = 0;  // left
  double s = 0, r = 0;            // right
  double determinant() const { return ss * rr - sr * sr; }
  bool tells_rate() const { return determinant() > 1e-9 * ss * rr; }

  void add(const EpipolarMiss& m, double error, double weight) {
    const double by_rate = m.slope * m.seconds;
    ss += weight * m.slope * m.slope;
    sr += weight * m.slope * by_rate;
    rr += weight * by_rate * by_rate;
    s += weight * m.slope * error;
    r += weight * by_rate * error;
  }
  void solve(bool with_rate, PairShift& shift) const {
    if (!with_rate || !tells_rate()) {
      shift.shift += s / ss;
      return;
    }
    shift.shift += (rr * s - sr * r) / determinant();
    shift.rate += (ss * r - sr * s) / determinant();
  }
};

/// Iterated least squares from `shift`, for the shift alone or with its rate. False where too few
/// misses are near.
bool refine(const std::vector<EpipolarMiss>& moving, bool with_rate, PairShift& shift) {
  double sigma = kAgreeingPixels;
  ShiftEquations equations;
  for (int round = 0; round < 20; ++round) {
    equations = {};
    shift.support = 0;
    std::vector<double> near;
    for (const EpipolarMiss& m : moving) {
      const double error = error_of(m, shift);
      equations.add(m, error, cauchy_weight(error, sigma));
      if (std::abs(error) < 3 * kAgreeingPixels) near.push_back(std::abs(error));
      shift.support += std::abs(error) < kAgreeingPixels ? 1 : 0;
    }
    if (near.size() < kFewestMisses) return false;
    equations.solve(with_rate, shift);
    sigma = std::clamp(1.4826 * median(near), 0.05, kAgreeingPixels);
  }
  shift.sigma = kCorrelation * sigma / std::sqrt(equations.ss);
  shift.rate_sigma = equations.tells_rate()
                         ? kCorrelation * sigma * std::sqrt(equations.ss / equations.determinant())
                         : std::numeric_limits<double>::infinity();
  return true;
}

/// Where fewer than a third agree, the matches are mostly wrong and any shift would do.
bool is_agreed(const PairShift& shift, size_t moving, double reach) {
  return shift.support >= kFewestMisses && 3 * shift.support >= moving &&
         std::abs(shift.shift) <= reach;
}

}  // namespace

double median_offset(std::vector<double> offsets) {
  return offsets.empty() ? 0 : lower_median(std::move(offsets));
}

std::vector<SolvedOffset> solve_offsets(int count, const std::vector<PairOffset>& pairs) {
  constexpr int kRounds = 30;
  std::vector<SolvedOffset> solved(static_cast<size_t>(count));
  if (pairs.empty()) return solved;
  const std::vector<bool> inside = largest_group(count, pairs);
  std::vector<double> offsets(solved.size()), weights;
  for (const PairOffset& pair : pairs) weights.push_back(1 / (pair.sigma * pair.sigma));
  std::vector<double> variances;
  double spread = 1;  // residuals of the pairs relative to their stated errors
  const double shrunk = shrunk_by(pairs, inside);
  for (int round = 0; round < kRounds; ++round) {
    variances = solve_weighted(pairs, weights, inside, offsets);
    std::vector<double> misfit;
    for (const PairOffset& pair : pairs)
      misfit.push_back(pair.offset - (offsets[size_t(pair.b)] - offsets[size_t(pair.a)]));
    std::vector<double> relative;
    for (size_t p = 0; p < pairs.size(); ++p)
      relative.push_back(std::abs(misfit[p]) / pairs[p].sigma);
    spread = std::max(1.0, 1.4826 * median(relative) / shrunk);
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
      solved[i] = {offsets[i] - middle, spread * std::sqrt(std::max(0.0, variances[i])), true};
  return solved;
}

std::vector<double> offset_limits(const std::vector<SolvedOffset>& solved,
                                  const std::vector<double>& frame_seconds) {
  constexpr double kLeast = 0.1, kMost = 0.5;  // frames
  constexpr double kStandsOut = 5 * 1.4826;    // medians of sizes: five standard deviations
  std::vector<double> sizes;                   // frames
  for (size_t i = 0; i < solved.size(); ++i)
    if (solved[i].determined)
      sizes.push_back(std::abs(solved[i].offset) / std::max(frame_seconds[i], 1e-9));
  const double middle = sizes.empty() ? 0 : median(sizes);
  const double frames =
      middle < kLeast ? std::max(kLeast, std::min(kStandsOut * middle, kMost)) : kLeast;
  std::vector<double> limits;
  for (size_t i = 0; i < solved.size(); ++i)
    limits.push_back(solved[i].determined ? std::max(3 * solved[i].sigma, frames * frame_seconds[i])
                                          : 0);
  return limits;
}

std::optional<PairShift> shift_from_misses(const std::vector<EpipolarMiss>& misses, double reach,
                                           double frame_seconds, double rate_reach) {
  constexpr double kSlowest = 0.2;  // pixels a frame; slower points do not determine time
  std::vector<EpipolarMiss> moving;
  for (const EpipolarMiss& m : misses)
    if (std::abs(m.slope) * frame_seconds > kSlowest) moving.push_back(m);
  if (moving.size() < kFewestMisses) return std::nullopt;
  PairShift found = most_votes(moving, reach, 0, frame_seconds);
  bool agreed = refine(moving, false, found) && is_agreed(found, moving.size(), reach);
  if (rate_reach > 0 && (!agreed || 5 * found.support < 3 * moving.size())) {
    PairShift drifting = most_votes(moving, reach, rate_reach, frame_seconds);
    if (drifting.rate != 0 && refine(moving, true, drifting) &&
        is_agreed(drifting, moving.size(), reach) &&
        (!agreed || 4 * drifting.support > 5 * found.support))
      return drifting;
  }
  if (!agreed) return std::nullopt;
  PairShift line = found;  // the constant shift with the rate measured separately
  if (!refine(moving, true, line)) line.rate_sigma = std::numeric_limits<double>::infinity();
  found.rate = line.rate;
  found.rate_sigma = line.rate_sigma;
  return found;
}

}  // namespace tessera
