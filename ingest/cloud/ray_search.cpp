// All planes of one camera after another, in loops that run in vectors; then the better half of the
// cameras at each plane.
#include "ingest/cloud/ray_search.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <utility>

#include "ingest/cloud/grey_patch.h"

namespace tessera {
namespace {

using PlaneCosts = std::array<float, size_t(kMostPlanes)>;

class RaySearch {
 public:
  /// Around a pixel, in colour and in grey; of `count` other cameras.
  RaySearch(const Patch& patch, const GreyPatch& grey, const RaySight* sights, int count,
            const RayPlanes& planes)
      : patch_(patch), grey_(grey), sights_(sights), count_(count), planes_(planes) {}

  /// The best plane, if no other valley is nearly as deep.
  std::optional<int> best_plane() const;
  double refined(int plane) const;
  /// Levels, in colour and between pixels; `best` becomes the view that agrees most.
  float fine(double plane, int& best) const;

 private:
  /// Levels, in grey and at whole pixels, at every plane; kNotCompared where it is not.
  void compare(const RaySight& sight, PlaneCosts& costs) const;

  const Patch& patch_;
  const GreyPatch& grey_;
  const RaySight* sights_;
  int count_;
  RayPlanes planes_;
};

void RaySearch::compare(const RaySight& sight, PlaneCosts& costs) const {
  std::array<int, size_t(kMostPlanes)> x, y;  // of its pixels; −1: none
  for (int k = 0; k < planes_.count; ++k) {
    double u, v;
    const bool shown = sight.has_patch_at(planes_.inverse(k), u, v);
    x[size_t(k)] = shown ? int(u) : -1;
    y[size_t(k)] = shown ? int(v) : -1;
  }
  const SearchView& view = *sight.view;
  int last_x = -1, last_y = -1;
  float cost = kNotCompared;
  for (size_t k = 0; k < size_t(planes_.count); ++k) {
    if (x[k] != last_x || y[k] != last_y) {  // planes may share a pixel
      last_x = x[k];
      last_y = y[k];
      cost = kNotCompared;
      if (x[k] >= 0 && !view.ignores(x[k], y[k])) {
        const GreyPatch other = grey_patch_at(view.grey, view.image.width, x[k], y[k]);
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
  std::array<PlaneCosts, size_t(kMostSights)> costs;
  PlaneCosts mean;
  std::array<int, size_t(kMostPlanes)> seen{};  // by so many cameras
  for (int i = 0; i < kMostSights; ++i) {
    PlaneCosts& of_sight = costs[size_t(i)];
    if (i < count_)
      compare(sights_[i], of_sight);
    else
      std::fill_n(of_sight.begin(), planes_.count, kNotCompared);
    for (size_t k = 0; k < size_t(planes_.count); ++k)
      seen[k] += of_sight[k] < kNotCompared ? 1 : 0;
  }
  for (const auto& [low, high] : kNetwork)
    for (size_t k = 0; k < size_t(planes_.count); ++k) {
      const float a = costs[size_t(low)][k], b = costs[size_t(high)][k];
      costs[size_t(low)][k] = std::min(a, b);
      costs[size_t(high)][k] = std::max(a, b);
    }
  for (size_t k = 0; k < size_t(planes_.count); ++k)
    mean[k] = better_half_mean(costs[0][k], costs[1][k], costs[2][k], costs[3][k], seen[k]);
  const int best = int(std::min_element(mean.begin(), mean.begin() + planes_.count) - mean.begin());
  const float least = mean[size_t(best)];
  if (least >= kNoAgreement) return std::nullopt;
  for (int k = 0; k < planes_.count; ++k)
    if (is_rival(k, mean[size_t(k)], best, least)) return std::nullopt;
  return best;
}

float RaySearch::fine(double plane, int& best) const {
  float costs[kMostSights];
  for (int i = 0; i < count_; ++i) costs[i] = fine_cost(patch_, sights_[i], planes_.inverse(plane));
  return agreement(costs, sights_, count_, best);
}

double RaySearch::refined(int plane) const {
  float costs[2 * kFineSteps + 1];
  int agreeing;
  for (int i = 0; i <= 2 * kFineSteps; ++i)
    costs[i] = fine(plane + kFineStep * (i - kFineSteps), agreeing);
  return refined_plane(plane, costs);
}

}  // namespace

RayDepth ray_depth(const std::vector<SearchView>& views, const DepthRange& range,
                   const RayQuery& query) {
  const auto [index, x, y] = query.pixel;
  const SearchView& view = views[size_t(index)];
  if (!has_patch(view.image, x, y) || view.ignores(x, y)) return {};
  const Patch patch = patch_at(view.image, x, y);
  const float structure = texture(patch);
  if (structure < kLeastTexture) return {};
  const glm::dvec3 ray = ray_of(view, x, y);
  RaySight sights[kMostSights];
  for (int i = 0; i < view.other_count; ++i) {
    const int other = view.others[i];
    sights[i] = sight_of(view, ray, query.velocity, views[size_t(other)], other);
  }
  const SearchView& median = views[size_t(view.others[view.other_count / 2])];
  const RayPlanes planes = planes_of(view, median, range);
  const GreyPatch grey = grey_patch_at(view.grey, view.image.width, x, y);
  const RaySearch search(patch, grey, sights, view.other_count, planes);

  const std::optional<int> plane = search.best_plane();
  if (!plane) return {};
  const double fine = search.refined(*plane);
  int best = -1;
  const float cost = search.fine(fine, best);
  const double inverse = planes.inverse(fine);
  if (!(cost < most_cost(structure)) || !(inverse > 0)) return {};
  return {inverse, best, cost};
}

}  // namespace tessera
