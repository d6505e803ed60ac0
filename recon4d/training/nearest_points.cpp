// A k-d tree by median splits over an array of indices, with exact nearest neighbours.
#include "recon4d/training/nearest_points.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int64_t kLeaf = 8;             // points that are scanned rather than split
constexpr int64_t kPointsOfTask = 1024;  // points per task

/// The nearest met so far: their squared distances, ascending.
struct Nearest {
  static constexpr int kMost = 3;
  std::array<float, kMost> squared;
  int found = 0;

  void offer(float value) {
    if (!reaches(value)) return;
    int place = std::min(found, kMost - 1);
    for (; place > 0 && squared[size_t(place - 1)] > value; --place)
      squared[size_t(place)] = squared[size_t(place - 1)];
    squared[size_t(place)] = value;
    found = std::min(found + 1, kMost);
  }
  /// Whether a point at that squared distance is among them.
  bool reaches(float value) const { return found < kMost || value < squared[kMost - 1]; }
};

class Tree {
 public:
  explicit Tree(const std::vector<glm::vec3>& points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    axis_.resize(points.size());
    split(0, int64_t(points.size()));
  }

  /// Of point i among the others.
  Nearest of_point(int32_t i) const {
    Nearest nearest;
    search(0, int64_t(order_.size()), points_[size_t(i)], i, nearest);
    return nearest;
  }
  /// Of any place.
  Nearest of_place(const glm::vec3& place) const {
    Nearest nearest;
    search(0, int64_t(order_.size()), place, -1, nearest);
    return nearest;
  }
  int32_t at(int64_t position) const { return order_[size_t(position)]; }

 private:
  void split(int64_t begin, int64_t end) {
    if (end - begin <= kLeaf) return;
    glm::vec3 low(std::numeric_limits<float>::max());
    glm::vec3 high(-std::numeric_limits<float>::max());
    for (int64_t k = begin; k < end; ++k)
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], points_[size_t(at(k))][a]);
        high[a] = std::max(high[a], points_[size_t(at(k))][a]);
      }
    const glm::vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const int64_t middle = (begin + end) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](int32_t a, int32_t b) { return points_[size_t(a)][axis] < points_[size_t(b)][axis]; });
    axis_[size_t(middle)] = uint8_t(axis);
    split(begin, middle);
    split(middle + 1, end);
  }

  void offer(int64_t position, const glm::vec3& place, int32_t left_out, Nearest& nearest) const {
    const int32_t other = at(position);
    if (other == left_out) return;
    const glm::vec3 d = points_[size_t(other)] - place;
    nearest.offer(d.x * d.x + d.y * d.y + d.z * d.z);
  }

  void search(int64_t begin, int64_t end, const glm::vec3& place, int32_t left_out,
              Nearest& nearest) const {
    if (end - begin <= kLeaf) {
      for (int64_t k = begin; k < end; ++k) offer(k, place, left_out, nearest);
      return;
    }
    const int64_t middle = (begin + end) / 2;
    const int axis = axis_[size_t(middle)];
    const float offset = place[axis] - points_[size_t(at(middle))][axis];
    const bool below = offset < 0;
    search(below ? begin : middle + 1, below ? middle : end, place, left_out, nearest);
    offer(middle, place, left_out, nearest);
    if (nearest.reaches(offset * offset))
      search(below ? middle + 1 : begin, below ? end : middle, place, left_out, nearest);
  }

  const std::vector<glm::vec3>& points_;
  std::vector<int32_t> order_;
  std::vector<uint8_t> axis_;
};

}  // namespace

std::vector<float> mean_squared_neighbour_distance(const std::vector<glm::vec3>& points) {
  std::vector<float> result(points.size(), 0.0f);
  const Tree tree(points);
  parallel_for(int64_t(points.size()), kPointsOfTask, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const Nearest nearest = tree.of_point(tree.at(k));
      float sum = 0;
      for (int j = 0; j < nearest.found; ++j) sum += nearest.squared[size_t(j)];
      result[size_t(tree.at(k))] = nearest.found > 0 ? sum / float(nearest.found) : 0.0f;
    }
  });
  return result;
}

std::vector<float> squared_distance_to_nearest(const std::vector<glm::vec3>& points,
                                               const std::vector<glm::vec3>& others) {
  std::vector<float> result(points.size(), std::numeric_limits<float>::infinity());
  if (others.empty()) return result;
  const Tree tree(others);
  parallel_for(int64_t(points.size()), kPointsOfTask, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i)
      result[i] = tree.of_place(points[i]).squared[0];
  });
  return result;
}

}  // namespace tessera
