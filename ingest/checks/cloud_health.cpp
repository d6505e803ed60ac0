// Counts of points in the views of the cameras. A comparison of the colours of points and images
// finds a wrong axis convention.
#include "ingest/checks/cloud_health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "ingest/checks/stations.h"
#include "kernels/base/camera_rig.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr int64_t kFewPoints = 1000;
constexpr size_t kColourSamples = 3000;
constexpr double kChance = 0.8;  // of another point's colour: no better than chance

double share(int64_t part, int64_t whole) {
  return whole == 0 ? 0 : double(part) / double(whole);
}

bool finite(const glm::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Distance beyond which a point is far: ten times the median distance camera – point.
void count_places(const Scene& scene, const std::vector<Station>& stations, CloudHealth& health) {
  std::set<std::tuple<float, float, float>> places;
  std::vector<double> distances;
  glm::dvec3 middle(0.0);
  for (const Station& station : stations) middle += station.camera.position();
  middle /= double(stations.size());
  for (const glm::vec3& p : scene.points.position) {
    if (!finite(p)) {
      ++health.not_finite;
      continue;
    }
    if (!places.insert({p.x, p.y, p.z}).second) ++health.duplicates;
    distances.push_back(glm::length(glm::dvec3(p) - middle));
    int seen = 0;
    double x = 0, y = 0;
    for (size_t s = 0; s < stations.size() && seen < 2; ++s)
      seen += project_into(stations[s].camera, glm::dvec3(p), x, y);
    health.unseen += seen == 0;
    health.seen_by_one += seen == 1;
  }
  if (distances.empty()) return;
  const double far = 10 * median(distances);
  health.far = std::count_if(distances.begin(), distances.end(), [=](double d) { return d > far; });
}

double difference(const std::array<uint8_t, 3>& a, const std::array<double, 3>& b) {
  double sum = 0;
  for (size_t k = 0; k < 3; ++k) sum += std::abs(double(a[k]) - b[k]);
  return sum;
}

double quantile(std::vector<double>& values, size_t numerator, size_t denominator) {
  const auto nth = values.begin() + std::ptrdiff_t(values.size() * numerator / denominator);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Median over points of the lower quartile over cameras (some are hidden from it); against the
/// colour of a point far away in the list, which has the same distribution of colours.
double colour_ratio(const Scene& scene, const std::vector<Station>& stations) {
  const PointCloud& cloud = scene.points;
  const size_t count = cloud.position.size();
  const size_t step = std::max<size_t>(1, count / kColourSamples);
  std::vector<Image8> images;
  for (const Station& station : stations) images.push_back(median_image(scene, station));
  std::vector<double> own_differences, other_differences;
  for (size_t i = 0; i < count; i += step) {
    if (!finite(cloud.position[i])) continue;
    std::vector<double> own_cameras, other_cameras;
    const auto& another = cloud.colour[(i + count / 2 + 17 * i) % count];
    for (size_t s = 0; s < stations.size(); ++s) {
      double x = 0, y = 0;
      if (!project_into(stations[s].camera, cloud.position[i], x, y)) continue;
      const std::array<double, 3> colour = colour_at(images[s], x, y);
      if (*std::min_element(colour.begin(), colour.end()) < 0) continue;
      own_cameras.push_back(difference(cloud.colour[i], colour));
      other_cameras.push_back(difference(another, colour));
    }
    if (own_cameras.empty()) continue;
    own_differences.push_back(quantile(own_cameras, 1, 4));
    other_differences.push_back(quantile(other_cameras, 1, 4));
  }
  constexpr size_t kLeast = 50;
  if (own_differences.size() < kLeast) return -1;
  const double chance = quantile(other_differences, 1, 2);
  // not measurable for one colour everywhere
  return chance < 6 ? -1 : quantile(own_differences, 1, 2) / chance;
}

void judge(const Scene& scene, CloudHealth& health) {
  const auto add = [&](Severity severity, std::string measured, std::string advice) {
    health.findings.push_back({severity, "cloud", "", std::move(measured), std::move(advice)});
  };
  const int64_t points = health.points;
  const int64_t usable = points - health.not_finite;
  if (points == 0) {
    add(scene.had_alpha ? Severity::kInfo : Severity::kWarning, "no initial cloud",
        "training begins from random points or a plane sweep (--sweep); a COLMAP cloud "
        "(points3D.ply beside the capture) usually helps more than anything else");
    return;
  }
  if (health.not_finite > 0)
    add(Severity::kError, fmt::format("{} of {} points are not finite", health.not_finite, points),
        "export the cloud again or remove these points");
  if (points < kFewPoints)
    add(Severity::kWarning, fmt::format("{} points", points),
        "that is few: give a denser cloud, or train with --sweep true");
  if (share(health.unseen, usable) > 0.5)
    add(Severity::kError,
        fmt::format("{:.0f} % of the points are in no training image",
                    100 * share(health.unseen, usable)),
        "cloud and poses are not of one world, or the axes differ (OpenCV against OpenGL): export "
        "both from one model");
  if (health.colour_ratio > kChance)
    add(Severity::kError,
        fmt::format("points do not project onto their colours (difference {:.2f} of chance)",
                    health.colour_ratio),
        "axis convention or world of the cloud differs from the poses': export both from one "
        "model");
  if (share(health.far, usable) > 0.02)
    add(Severity::kWarning,
        fmt::format("{:.1f} % of the points are more than ten times as far as the median",
                    100 * share(health.far, usable)),
        "remove the outliers: they become huge Gaussians");
  if (share(health.duplicates, usable) > 0.05)
    add(Severity::kWarning,
        fmt::format("{:.0f} % of the points lie on another one",
                    100 * share(health.duplicates, usable)),
        "remove duplicates: they double opacity at the start");
  add(Severity::kInfo,
      fmt::format("{} points, {:.0f} % seen by fewer than 2 training cameras", points,
                  100 * share(health.unseen + health.seen_by_one, usable)),
      "");
}

}  // namespace

CloudHealth check_cloud(const Scene& scene) {
  CloudHealth health;
  health.points = int64_t(scene.points.position.size());
  const std::vector<Station> stations = training_stations(scene);
  if (health.points > 0 && !stations.empty()) {
    count_places(scene, stations, health);
    health.colour_ratio = colour_ratio(scene, stations);
  }
  judge(scene, health);
  return health;
}

std::optional<double> nearest_depth(const Scene& scene) {
  constexpr size_t kLeastPoints = 500, kPointsPerOutlier = 500;
  std::optional<double> nearest;
  std::set<std::string> known;
  std::vector<double> depths;
  for (const int f : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(f)];
    if (!known.insert(frame.camera_name).second) continue;
    depths.clear();
    for (const glm::vec3& point : scene.points.position) {
      const glm::dvec3 p(point);
      if (sees(frame.camera, p, 0))
        depths.push_back((frame.camera.cam_from_world * p + frame.camera.translation).z);
    }
    if (depths.size() < kLeastPoints) continue;
    const auto first = depths.begin() + std::ptrdiff_t(depths.size() / kPointsPerOutlier);
    std::nth_element(depths.begin(), first, depths.end());
    if (!nearest || *first < *nearest) nearest = *first;
  }
  return nearest;
}

}  // namespace tessera
