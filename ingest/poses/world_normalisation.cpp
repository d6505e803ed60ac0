// Estimates up, centre and scale of a capture by medians instead of means.
#include "ingest/poses/world_normalisation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "kernels/math/eigen3.h"

namespace tessera {
namespace {

using glm::dmat3;
using glm::dvec3;

constexpr int kReweightings = 50;  // Weiszfeld's iteration converges linearly
constexpr double kSwing = 0.1;     // second eigenvalue of right axes: about ±20° of an orbit
constexpr double kLevel = 0.1;     // smallest by second eigenvalue: a level horizon
constexpr double kUpAgreement = 0.7071;  // cosine of 45° to the mean up: else the horizon is no up
// Smallest eigenvalue of the mean of I − d dᵀ: of two axes 5.7° apart, the least of method E.3.
constexpr double kMeeting = 0.0025;
constexpr double kNearest = 0.3;        // 1.5 × the near plane 0.2
constexpr double kMostEnlarged = 8;     // keeps the cameras' distance, 32, within the far plane 100
constexpr double kNearQuantile = 0.01;  // points nearer than this share are taken for outliers

dvec3 forward_of(const Camera& camera) {
  return glm::transpose(camera.cam_from_world)[2];
}

Sym3<double> outer_sum(const std::vector<dvec3>& vectors) {
  Sym3<double> sum{};
  for (const dvec3& v : vectors) sum += symmetric_outer(v, v);
  return sum;
}

/// Indices of the eigenvalues, ascending.
std::array<int, 3> ascending(const Vec3<double>& values) {
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  return order;
}

/// The direction to which the sum of angles' chords is least; outlying axes count little.
dvec3 median_direction(const std::vector<dvec3>& directions) {
  dvec3 mean(0.0);
  for (const dvec3& d : directions) mean += d;
  for (int i = 0; i < kReweightings && glm::length(mean) > 0; ++i) {
    const dvec3 current = glm::normalize(mean);
    mean = dvec3(0.0);
    for (const dvec3& d : directions) mean += d / std::max(1e-6, glm::length(d - current));
  }
  return glm::length(mean) > 0 ? glm::normalize(mean) : directions.front();
}

dvec3 find_up(const std::vector<Camera>& cameras) {
  std::vector<dvec3> up, right;
  for (const Camera& camera : cameras) {
    const dmat3 world_from_cam = glm::transpose(camera.cam_from_world);
    up.push_back(-world_from_cam[1]);
    right.push_back(world_from_cam[0]);
  }
  const dvec3 mean_up = median_direction(up);
  const Eigen3 eigen = symmetric_eigen(outer_sum(right));
  const std::array<int, 3> order = ascending(eigen.values);
  const double count = double(cameras.size());
  const double smallest = eigen.values[order[0]] / count, second = eigen.values[order[1]] / count;
  const dvec3 across = eigen.vectors[order[0]];
  const double cosine = glm::dot(across, mean_up);
  if (second < kSwing || smallest > kLevel * second || std::abs(cosine) < kUpAgreement)
    return mean_up;
  return cosine < 0 ? -across : across;
}

/// The shortest rotation that turns the unit vector `up` to +z; half a turn about x for −z.
dmat3 rotation_to_z(const dvec3& up) {
  if (up.z < -1 + 1e-12) return dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  const dvec3 v(up.y, -up.x, 0);  // up × z
  const dmat3 cross(0, v.z, -v.y, -v.z, 0, v.x, v.y, -v.x, 0);
  return dmat3(1.0) + cross + cross * cross * (1 / (1 + up.z));
}

double distance_to_axis(const dvec3& point, const Camera& camera) {
  return glm::length(glm::cross(point - camera.position(), forward_of(camera)));
}

/// Where the viewing axes meet, if they do in front of most cameras.
bool find_meeting(const std::vector<Camera>& cameras, dvec3& centre) {
  std::vector<double> weights(cameras.size(), 1.0);
  for (int i = 0; i < kReweightings; ++i) {
    dmat3 sum(0.0);
    dvec3 right_side(0.0);
    double total = 0;
    for (size_t c = 0; c < cameras.size(); ++c) {
      const dvec3 d = forward_of(cameras[c]);
      const dmat3 across = weights[c] * (dmat3(1.0) - glm::outerProduct(d, d));
      sum += across;
      right_side += across * cameras[c].position();
      total += weights[c];
    }
    const Eigen3 eigen = symmetric_eigen({sum[0][0], sum[1][0], sum[2][0],  //
                                          sum[1][1], sum[2][1], sum[2][2]});
    if (eigen.values[ascending(eigen.values)[0]] < kMeeting * total) return false;
    centre = glm::inverse(sum) * right_side;
    for (size_t c = 0; c < cameras.size(); ++c) {
      const double floor = 1e-3 * glm::length(centre - cameras[c].position());
      weights[c] = 1 / std::max({distance_to_axis(centre, cameras[c]), floor, 1e-300});
    }
    const double largest = *std::max_element(weights.begin(), weights.end());
    for (double& weight : weights) weight /= largest;
  }
  const auto in_front = std::count_if(cameras.begin(), cameras.end(), [&](const Camera& camera) {
    return glm::dot(centre - camera.position(), forward_of(camera)) > 0;
  });
  return 2 * in_front > std::ptrdiff_t(cameras.size());
}

/// Depths of the points before the cameras, at most about 10⁶ of them: of all, or of those that
/// lie in the image, for which intrinsics must be known.
enum class Points { kInFront, kInView };
std::vector<double> depths_of(Points which, const std::vector<Camera>& cameras,
                              const PointCloud& points) {
  constexpr size_t kMost = 1'000'000;
  const size_t stride = 1 + points.position.size() * cameras.size() / kMost;
  std::vector<double> depths;
  for (const Camera& camera : cameras)
    for (size_t i = 0; i < points.position.size(); i += stride) {
      const dvec3 p = camera.cam_from_world * dvec3(points.position[i]) + camera.translation;
      if (!(p.z > 0)) continue;
      const double x = camera.fl_x * p.x / p.z + camera.cx;
      const double y = camera.fl_y * p.y / p.z + camera.cy;
      const bool in_view = x >= 0 && y >= 0 && x < camera.width && y < camera.height;
      if (which == Points::kInFront || in_view) depths.push_back(p.z);
    }
  return depths;
}

}  // namespace

Similarity normalised_from_source(const std::vector<Camera>& cameras, const PointCloud& points) {
  check(!cameras.empty(), "normalised_from_source: no cameras");
  const std::vector<double> depths = depths_of(Points::kInView, cameras, points);
  const double median_depth = depths.empty() ? 0 : quantile(depths, 0.5);
  dvec3 centre(0.0);
  const bool meet = find_meeting(cameras, centre);
  if (!meet) {
    centre = dvec3(0.0);
    for (const Camera& camera : cameras)
      centre += (camera.position() + median_depth * forward_of(camera)) / double(cameras.size());
  }
  std::vector<double> distances;
  for (const Camera& camera : cameras) distances.push_back(glm::length(camera.position() - centre));
  double size = quantile(distances, 0.5);
  if (!meet) size = std::max(size, median_depth);
  Similarity result;
  if (size > 0) result.scale = kNormalisedDistance / size;
  if (!depths.empty()) {
    const double nearest = result.scale * quantile(depths, kNearQuantile);
    if (nearest < kNearest) result.scale *= std::min(kMostEnlarged, kNearest / nearest);
  }
  result.rotation = rotation_to_z(find_up(cameras));
  result.translation = -result.scale * (result.rotation * centre);
  return result;
}

Similarity usable_from_stated(const std::vector<Camera>& cameras, const PointCloud& points) {
  constexpr double kMostOff = 10;     // from kNormalisedDistance
  constexpr double kDepthApart = 10;  // of the distances of cameras whose axes do not meet
  if (cameras.empty()) return {};
  dvec3 centre(0.0);
  const bool meet = find_meeting(cameras, centre);
  if (!meet)
    for (const Camera& camera : cameras) centre += camera.position() / double(cameras.size());
  std::vector<double> distances;
  for (const Camera& camera : cameras) distances.push_back(glm::length(camera.position() - centre));
  double size = quantile(distances, 0.5);
  if (!meet) {
    const std::vector<double> depths = depths_of(Points::kInFront, cameras, points);
    size = depths.empty() ? kDepthApart * size : quantile(depths, 0.5);
    for (const Camera& camera : cameras)
      centre += size / double(cameras.size()) * forward_of(camera);
  }
  Similarity change;
  const double scale = size > 0 ? kNormalisedDistance / size : 1;
  if (scale >= 1 / kMostOff && scale <= kMostOff) return change;
  change.scale = scale;
  change.translation = -scale * centre;
  return change;
}

std::string stated_world_text(const Similarity& prepared_from_source) {
  if (prepared_from_source.is_identity()) return "";
  const Similarity source_from_prepared = inverse(prepared_from_source);
  constexpr double kRounding = 1e-9;  // prepared units: no distance
  dvec3 centre = source_from_prepared.translation;
  for (int i = 0; i < 3; ++i)
    if (std::abs(centre[i]) * prepared_from_source.scale < kRounding) centre[i] = 0;
  return fmt::format(
      "the world of the poses is scaled by {:.6g} and has its origin at ({:.6g}, {:.6g}, {:.6g}); "
      "exports lead back",
      prepared_from_source.scale, centre.x, centre.y, centre.z);
}

}  // namespace tessera
