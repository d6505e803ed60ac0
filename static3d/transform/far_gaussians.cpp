// Shells by doubled distances, and the rows that a format can hold.
#include "static3d/transform/far_gaussians.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include "kernels/math/spherical_harmonics.h"

namespace tessera {
namespace {

/// 0 up to `core`, 1 up to twice of it, and so on.
int shell_at(double distance, double core) {
  return distance > core ? std::max(1, int(std::ceil(std::log2(distance / core)))) : 0;
}

/// The means of `rows` as a set of their own would be sorted.
std::vector<int64_t> along_curve(const GaussianSpans<const float>& set,
                                 const std::vector<int64_t>& rows) {
  std::vector<float> means;
  means.reserve(3 * rows.size());
  for (const int64_t n : rows) means.insert(means.end(), set.at(kMean, n), set.at(kMean, n) + 3);
  GaussianSpans<const float> part;
  part.count = int64_t(rows.size());
  part.group[kMean] = {means.data(), int64_t(means.size())};
  std::vector<int64_t> order = morton_order(part);
  for (int64_t& n : order) n = rows[size_t(n)];
  return order;
}

}  // namespace

FarShells::FarShells(const GaussianSpans<const float>& set)
    : set_(set), box_(box_of_means({set})) {}

int FarShells::of_mean(int64_t n) const {
  if (!(box_.half_extent > 0)) return 0;
  double distance = 0;
  for (int k = 0; k < 3; ++k)
    distance = std::max(distance, std::abs(double(set_.at(kMean, n)[k]) - box_.centre[k]));
  return shell_at(distance, double(kCoreFactor) * box_.half_extent);
}

int FarShells::of_colour(int64_t n) const {
  double distance = 0;
  for (int c = 0; c < 3; ++c)
    distance = std::max(distance, std::abs(kSh0 * double(set_.at(kSh, n)[c])));
  return shell_at(distance, kCoreFactor);
}

HeldRows rows_within(const GaussianSpans<const float>& set, const FarShells& shells,
                     const std::function<bool(const float* mean)>& holds) {
  HeldRows held;
  for (int64_t n = 0; n < set.count; ++n)
    (holds(set.at(kMean, n)) || shells.of_mean(n) == 0 ? held.rows : held.beyond).push_back(n);
  return held;
}

HeldRows rows_in_chunks(const GaussianSpans<const float>& set, int64_t chunk) {
  const FarShells shells(set);
  std::map<int, std::vector<int64_t>, std::greater<>> parts;
  for (int64_t n = 0; n < set.count; ++n)
    parts[std::max(shells.of_mean(n), shells.of_colour(n))].push_back(n);
  HeldRows held;
  std::deque<std::pair<int, int64_t>> open;  // shells and rows of the chunk that is not full
  const auto close = [&] {
    for (const auto& [shell, n] : open) held.rows.push_back(n);
    open.clear();
  };
  for (const auto& [shell, rows] : parts) {
    for (; !open.empty() && open.front().first - shell > (shell == 0 ? 1 : 3); open.pop_front())
      held.beyond.push_back(open.front().second);
    for (const int64_t n : along_curve(set, rows)) {
      open.emplace_back(shell, n);
      if (int64_t(open.size()) == chunk) close();
    }
  }
  close();
  return held;
}

}  // namespace tessera
