// Sorts the points along their widest axis; the search of each point ends where the distance along
// that axis exceeds its farthest neighbour.
#include "ingest/cloud/nearest_few.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

glm::length_t widest_axis(const std::vector<glm::vec3>& points) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
  for (const glm::vec3& point : points) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  const glm::vec3 size = high - low;
  if (size.x >= size.y && size.x >= size.z) return 0;
  return size.y >= size.z ? 1 : 2;
}

/// Those met so far, ascending.
class Nearest {
 public:
  explicit Nearest(size_t count) : count_(count) {}
  bool reaches(float distance) const {
    return found_.size() < count_ || distance < found_.back().distance;
  }
  void offer(Neighbour neighbour) {
    if (!reaches(neighbour.distance)) return;
    const auto nearer = [](const Neighbour& a, const Neighbour& b) {
      return a.distance < b.distance;
    };
    found_.insert(std::upper_bound(found_.begin(), found_.end(), neighbour, nearer), neighbour);
    if (found_.size() > count_) found_.pop_back();
  }
  std::vector<Neighbour> take() { return std::move(found_); }

 private:
  size_t count_;
  std::vector<Neighbour> found_;
};

}  // namespace

std::vector<std::vector<Neighbour>> nearest_few(const std::vector<glm::vec3>& points, int count) {
  constexpr int64_t kGrain = 256;  // points
  std::vector<std::vector<Neighbour>> all(points.size());
  if (count < 1) return all;
  const glm::length_t axis = widest_axis(points);
  std::vector<int32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
    return points[size_t(a)][axis] < points[size_t(b)][axis];
  });
  const auto place = [&](int64_t at) { return points[size_t(order[size_t(at)])]; };
  const auto end = int64_t(order.size());
  parallel_for(end, kGrain, [&](int64_t from, int64_t to) {
    for (int64_t k = from; k < to; ++k) {
      Nearest nearest{size_t(count)};
      int64_t below = k - 1, above = k + 1;
      const auto look = [&](int64_t& other, int direction) {
        if (other < 0 || other >= end) return false;
        const glm::vec3 apart = place(other) - place(k);
        if (!nearest.reaches(std::abs(apart[axis]))) return false;
        nearest.offer({glm::length(apart), order[size_t(other)]});
        other += direction;
        return true;
      };
      bool more = true;
      while (more) {
        more = look(below, -1);
        more = look(above, 1) || more;
      }
      all[size_t(order[size_t(k)])] = nearest.take();
    }
  });
  return all;
}

}  // namespace tessera
