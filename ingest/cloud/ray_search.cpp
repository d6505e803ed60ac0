// All planes of one camera after another, in loops that run in vectors; then the better half of the
// cameras at each plane.
#include "ingest/cloud/ray_search.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

constexpr int kValley = 3;          // planes on either side of the best that belong to it
constexpr double kFineStep = 0.25;  // of a plane
constexpr float kDistinct = 1.15f;  // second valley ÷ best
constexpr float kNoAgreement = 1e9f;
constexpr float kAbsent = 2e9f;  // of a camera that is not compared

/// Cameras of `count` whose mean is taken, so that occluded ones have no weight.
int better_half(int count) {
  return std::max(2, (count + 1) / 2);
}

}  // namespace

void RaySearch::compare(const RaySight& sight, PlaneCosts& costs) const {
  std::array<int, size_t(kMostPlanes)> x, y;  // of its pixels; −1: none
  for (int k = 0; k < planes_.count; ++k) {
    double u, v;
    const bool shown = sight.has_patch_at(inverse(k), u, v);
    x[size_t(k)] = shown ? int(u) : -1;
    y[size_t(k)] = shown ? int(v) : -1;
  }
  int last_x = -1, last_y = -1;
  float cost = kAbsent;
  for (size_t k = 0; k < size_t(planes_.count); ++k) {
    if (x[k] != last_x || y[k] != last_y) {  // planes may share a pixel
      last_x = x[k];
      last_y = y[k];
      cost = kAbsent;
      if (x[k] >= 0 && !sight.mask->ignores(x[k], y[k])) {
        const GreyPatch other = grey_patch_at(*sight.grey, x[k], y[k]);
        if (std::abs(grey_.sum - other.sum) <= kMostGain * Patch::kPixels)
          cost = difference(grey_, other);
      }
    }
    costs[k] = cost;
  }
}

std::optional<int> RaySearch::best_plane() const {
  static_assert(kMostSights == 8, "the network sorts eight");
  constexpr std::pair<int, int> kNetwork[] = {
      {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {0, 1}, {2, 3},
      {4, 5}, {6, 7}, {2, 4}, {3, 5}, {1, 4}, {3, 6}, {1, 2}, {3, 4}, {5, 6}};
  std::array<PlaneCosts, kMostSights> costs;
  PlaneCosts mean;
  std::array<int, size_t(kMostPlanes)> seen{};  // by so many cameras
  for (size_t i = 0; i < kMostSights; ++i) {
    if (i < sights_.size())
      compare(sights_[i], costs[i]);
    else
      std::fill_n(costs[i].begin(), planes_.count, kAbsent);
    for (size_t k = 0; k < size_t(planes_.count); ++k) seen[k] += costs[i][k] < kAbsent ? 1 : 0;
  }
  for (const auto& [low, high] : kNetwork)
    for (size_t k = 0; k < size_t(planes_.count); ++k) {
      const float a = costs[size_t(low)][k], b = costs[size_t(high)][k];
      costs[size_t(low)][k] = std::min(a, b);
      costs[size_t(high)][k] = std::max(a, b);
    }
  for (size_t k = 0; k < size_t(planes_.count); ++k) {
    const int half = better_half(seen[k]);
    float sum = costs[0][k] + costs[1][k];
    sum += half > 2 ? costs[2][k] : 0.0f;
    sum += half > 3 ? costs[3][k] : 0.0f;
    mean[k] = seen[k] < 2 ? kNoAgreement : sum / float(half);
  }
  const int best = int(std::min_element(mean.begin(), mean.begin() + planes_.count) - mean.begin());
  const float least = mean[size_t(best)];
  if (least >= kNoAgreement) return std::nullopt;
  for (int k = 0; k < planes_.count; ++k)
    if (std::abs(k - best) > kValley && mean[size_t(k)] < kDistinct * least) return std::nullopt;
  return best;
}

float RaySearch::fine(double plane, int& best) const {
  std::array<std::pair<float, int>, kMostSights> costs{};  // with the frame
  size_t count = 0;
  double u, v;
  for (const RaySight& sight : sights_) {
    if (!sight.at(inverse(plane), u, v)) continue;
    const Patch other = patch_between(*sight.image, u, v);
    if (brightness_difference(patch_, other) > kMostGain) continue;
    costs[count++] = {difference(patch_, other), sight.frame};
  }
  const int half = better_half(int(count));
  if (count >= 2)
    std::partial_sort(costs.begin(), costs.begin() + half, costs.begin() + long(count));
  best = costs[0].second;
  if (count < 2) return kNoAgreement;
  float sum = 0;
  for (int i = 0; i < half; ++i) sum += costs[size_t(i)].first;
  return sum / float(half);
}

double RaySearch::refined(int plane) const {
  constexpr int kSteps = 4;  // on either side
  std::array<float, size_t(2 * kSteps + 1)> costs;
  int agreeing;
  for (int i = 0; i <= 2 * kSteps; ++i)
    costs[size_t(i)] = fine(plane + kFineStep * (i - kSteps), agreeing);
  const int best = int(std::min_element(costs.begin(), costs.end()) - costs.begin());
  double vertex = 0;
  if (best > 0 && best < 2 * kSteps && costs[size_t(best) - 1] < kNoAgreement &&
      costs[size_t(best) + 1] < kNoAgreement) {
    const double a = costs[size_t(best) - 1], b = costs[size_t(best)], c = costs[size_t(best) + 1];
    if (a - 2 * b + c > 0) vertex = 0.5 * (a - c) / (a - 2 * b + c);
  }
  return plane + kFineStep * (best - kSteps + vertex);
}

}  // namespace tessera
