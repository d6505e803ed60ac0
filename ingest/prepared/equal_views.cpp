// A view is searched among those whose centres have nearly the same x.
#include "ingest/prepared/equal_views.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>

namespace tessera {
namespace {

constexpr double kFloatNoise = 1e-5;  // of a float after the arithmetic of an export

bool is_near(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::abs(*a - *b) <= kFloatNoise * std::max(std::abs(*a), std::abs(*b));
}

bool has_equal_intrinsics(const StatedIntrinsics& a, const StatedIntrinsics& b) {
  return is_near(a.fl_x, b.fl_x) && is_near(a.fl_y, b.fl_y) && is_near(a.cx, b.cx) &&
         is_near(a.cy, b.cy) && is_near(a.camera_angle_x, b.camera_angle_x) &&
         is_near(a.camera_angle_y, b.camera_angle_y) && a.w == b.w && a.h == b.h;
}

bool has_equal_rotation(const Camera& a, const Camera& b) {
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (std::abs(a.cam_from_world[c][r] - b.cam_from_world[c][r]) > kFloatNoise) return false;
  return true;
}

/// Numbers of `frames` in the order of their names, which the order of the file does not change.
std::vector<size_t> order_of_names(const std::vector<TransformsFrame>& frames) {
  std::vector<size_t> order(frames.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return frames[a].name < frames[b].name; });
  return order;
}

/// The diagonal of the box of all centres.
double extent_of(const std::vector<glm::dvec3>& centres) {
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const glm::dvec3& centre : centres) {
    low = glm::min(low, centre);
    high = glm::max(high, centre);
  }
  return centres.empty() ? 0 : glm::distance(low, high);
}

}  // namespace

std::vector<int> view_numbers(const std::vector<TransformsFrame>& frames) {
  std::vector<glm::dvec3> centres;
  for (const TransformsFrame& frame : frames) centres.push_back(frame.camera.position());
  const double tolerance = kFloatNoise * extent_of(centres);
  std::multimap<double, size_t> first_frames;  // of the views, by the x of their centres
  std::vector<int> numbers(frames.size(), -1);
  for (const size_t i : order_of_names(frames)) {
    const auto is_equal = [&](size_t k) {
      return glm::distance(centres[i], centres[k]) <= tolerance &&
             has_equal_rotation(frames[i].camera, frames[k].camera) &&
             has_equal_intrinsics(frames[i].intrinsics, frames[k].intrinsics) &&
             frames[i].lens.lens == frames[k].lens.lens;
    };
    const auto end = first_frames.upper_bound(centres[i].x + tolerance);
    for (auto near = first_frames.lower_bound(centres[i].x - tolerance); near != end; ++near)
      if (is_equal(near->second)) {
        numbers[i] = numbers[near->second];
        break;
      }
    if (numbers[i] >= 0) continue;
    numbers[i] = int(first_frames.size());
    first_frames.emplace(centres[i].x, i);
  }
  return numbers;
}

}  // namespace tessera
