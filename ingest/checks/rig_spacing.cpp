// Angles between cameras are those at the point nearest to their viewing axes.
#include "ingest/checks/rig_spacing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/camera_rig.h"
#include "kernels/base/counted.h"

namespace tessera {
namespace {

/// PSNR of test views by the number of training cameras.
struct Expected {
  int64_t cameras;
  Severity severity;
  const char* psnr;
};
constexpr Expected kExpected[] = {
    {3, Severity::kWarning, "less than 22 dB"},
    {4, Severity::kWarning, "about 21 to 25 dB"},
    {5, Severity::kWarning, "about 23 to 28 dB"},
    {7, Severity::kInfo, "about 25 to 31 dB"},
};

glm::dvec3 direction_from(const glm::dvec3& focus, const Camera& camera) {
  return glm::normalize(camera.position() - focus);
}

/// Whether no camera is nearer to the direction between a and b than these are.
bool are_neighbours(const std::vector<glm::dvec3>& direction, size_t a, size_t b) {
  const glm::dvec3 between = direction[a] + direction[b];
  const double nearest = glm::dot(between, direction[a]);
  for (size_t c = 0; c < direction.size(); ++c)
    if (c != a && c != b && glm::dot(between, direction[c]) > nearest) return false;
  return true;
}

}  // namespace

RigSpacing rig_spacing(const std::vector<Station>& stations) {
  std::vector<Camera> cameras;
  for (const Station& station : stations) cameras.push_back(station.camera);
  const CameraRig rig = make_camera_rig(cameras);
  RigSpacing spacing;
  spacing.cameras = int64_t(stations.size());
  spacing.angle = neighbour_angle(rig);
  std::vector<glm::dvec3> direction;
  for (const Camera& camera : cameras) direction.push_back(direction_from(rig.focus, camera));
  for (size_t a = 0; a < cameras.size(); ++a)
    for (size_t b = a + 1; b < cameras.size(); ++b) {
      const double angle = angle_at_focus(rig, cameras[a], cameras[b]);
      if (angle <= spacing.gap_angle || !are_neighbours(direction, a, b)) continue;
      spacing.gap_angle = angle;
      spacing.gap = {stations[a].name, stations[b].name};
    }
  return spacing;
}

std::optional<Finding> expected_views(const std::vector<Station>& stations, bool held_out) {
  const auto row = std::find_if(std::begin(kExpected), std::end(kExpected), [&](const Expected& e) {
    return int64_t(stations.size()) <= e.cameras;
  });
  if (stations.empty() || row == std::end(kExpected)) return std::nullopt;
  const RigSpacing rig = rig_spacing(stations);
  std::string advice =
      rig.gap[0].empty()
          ? "film with more cameras"
          : fmt::format("a further camera between {} and {}, {:.0f} degrees apart, helps most",
                        rig.gap[0], rig.gap[1], rig.gap_angle);
  if (held_out) advice += "; --held-out none trains with all that filmed, and scores none";
  return Finding{
      row->severity, "coverage", "",
      fmt::format("{}{}: expect new views of {}", counted(rig.cameras, "training camera"),
                  rig.angle > 0 ? fmt::format(", neighbours {:.0f} degrees apart", rig.angle) : "",
                  row->psnr),
      std::move(advice)};
}

}  // namespace tessera
