// Starts from entries whose density is the cube root of that of the values, which is the optimum
// of many entries (Panter and Dite, 1951), and iterates on prefix sums.
#include "static3d/transform/scalar_codebook.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr int kLloydIterations = 100;

using Entries = std::array<double, ScalarCodebook::kEntries>;

struct Reach {
  double low, high;
};

/// Of sorted values, without those that are so far from the median that the bins of a histogram
/// would be wider than what the others differ by.
Reach reach_of(const std::vector<float>& sorted) {
  constexpr double kMostDeviations = 64;  // median deviations: a Gaussian has 99.9 % within five
  const float middle = sorted[sorted.size() / 2];
  std::vector<float> deviations;
  deviations.reserve(sorted.size());
  for (const float x : sorted) deviations.push_back(std::abs(x - middle));
  const double most = kMostDeviations * double(median_in_place(deviations));
  const double low = double(sorted.front()), high = double(sorted.back());
  if (!(most > 0)) return {low, high};
  return {std::max(low, double(middle) - most), std::min(high, double(middle) + most)};
}

/// Entries at equal steps of the sum of cube roots of a histogram of sorted values. What is outside
/// of it is for the iterations, which move the outermost entries there.
Entries first_entries(const std::vector<float>& sorted) {
  constexpr int kBins = 4096;
  const auto [low, high] = reach_of(sorted);
  const double width = (high - low) / kBins;
  std::vector<double> cumulative(kBins + 1);
  auto begin = std::lower_bound(sorted.begin(), sorted.end(), float(low));
  for (int bin = 0; bin < kBins; ++bin) {
    const auto end = std::lower_bound(begin, sorted.end(), float(low + (bin + 1) * width));
    cumulative[size_t(bin) + 1] = cumulative[size_t(bin)] + std::cbrt(double(end - begin));
    begin = end;
  }
  Entries entries{};
  int bin = 0;
  for (size_t i = 0; i < entries.size(); ++i) {
    const double wanted = (double(i) + 0.5) / double(entries.size()) * cumulative.back();
    while (cumulative[size_t(bin) + 1] < wanted) ++bin;
    const double from = cumulative[size_t(bin)], to = cumulative[size_t(bin) + 1];
    entries[i] = low + (bin + (to > from ? (wanted - from) / (to - from) : 0.5)) * width;
  }
  return entries;
}

/// Moves each entry to the mean of the values that are nearest to it; whether any has moved.
bool move_to_means(Entries& entries, const std::vector<float>& sorted,
                   const std::vector<double>& sums) {
  bool moved = false;
  size_t begin = 0;
  const Entries before = entries;
  for (size_t i = 0; i < entries.size(); ++i) {
    size_t end = sorted.size();
    if (i + 1 < entries.size()) {
      const auto border = float(0.5 * (before[i] + before[i + 1]));
      end = size_t(std::lower_bound(sorted.begin() + int64_t(begin), sorted.end(), border) -
                   sorted.begin());
    }
    if (end > begin) entries[i] = (sums[end] - sums[begin]) / double(end - begin);
    moved = moved || entries[i] != before[i];
    begin = end;
  }
  return moved;
}

}  // namespace

ScalarCodebook::ScalarCodebook(std::vector<float> values) {
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  std::vector<float> distinct;
  std::unique_copy(values.begin(), values.end(), std::back_inserter(distinct));
  if (distinct.size() <= kEntries) {
    entries_.fill(distinct.back());
    std::copy(distinct.begin(), distinct.end(), entries_.begin());
    return;
  }
  std::vector<double> sums(values.size() + 1);
  for (size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + double(values[i]);
  Entries entries = first_entries(values);
  for (int i = 0; i < kLloydIterations; ++i)
    if (!move_to_means(entries, values, sums)) break;
  std::sort(entries.begin(), entries.end());
  for (size_t i = 0; i < entries.size(); ++i) entries_[i] = float(entries[i]);
}

uint8_t ScalarCodebook::nearest(float value) const {
  const auto above = std::lower_bound(entries_.begin(), entries_.end(), value);
  if (above == entries_.begin()) return 0;
  auto index = int(above - entries_.begin());
  if (above == entries_.end() || double(value) - *(above - 1) <= double(*above) - value) --index;
  return uint8_t(index);
}

}  // namespace tessera
