// Estimates the up direction that most cameras share, and the roll of each camera relative to it.
#include "ingest/checks/orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ingest/checks/stations.h"
#include "ingest/test_views.h"

namespace tessera {
namespace {

constexpr double kAlike = 45;      // degrees from the rig's up direction, within which one agrees
constexpr double kInSight = 0.35;  // of a unit vector: less of it lies in the image's plane

/// Cameras of one pose that have several frames.
std::vector<Station> fixed_cameras(const Scene& scene) {
  std::vector<Station> fixed = stations_of(scene);
  std::erase_if(fixed, [&](const Station& station) {
    return station.frames.size() < 2 ||
           scene.frames[size_t(station.frames.front())].camera_name != station.name;
  });
  return fixed;
}

/// Rows of cam_from_world are the camera's axes in the world: right, down, forward.
glm::dvec3 right_of(const Camera& camera) {
  return glm::transpose(camera.cam_from_world)[0];
}
glm::dvec3 up_of(const Camera& camera) {
  return -glm::transpose(camera.cam_from_world)[1];
}

CameraRoll roll_of(const Station& station, const glm::dvec3& up) {
  const double along_up = glm::dot(up, up_of(station.camera));
  const double along_right = glm::dot(up, right_of(station.camera));
  CameraRoll roll{station.name, 0, std::hypot(along_up, along_right) > kInSight};
  roll.degrees = std::atan2(along_right, along_up) * 180 / std::numbers::pi;
  return roll;
}

std::vector<size_t> agreeing(const std::vector<Station>& cameras, const glm::dvec3& up) {
  std::vector<size_t> places;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const CameraRoll roll = roll_of(cameras[i], up);
    if (roll.known && std::abs(roll.degrees) < kAlike) places.push_back(i);
  }
  return places;
}

/// The mean up direction of the cameras that agree with it, begun from each camera in turn; that of
/// the largest number of cameras, of the first among equals.
glm::dvec3 common_up(const std::vector<Station>& cameras) {
  constexpr int kRounds = 5;
  glm::dvec3 best(0);
  size_t most = 0;
  for (const Station& first : cameras) {
    glm::dvec3 up = up_of(first.camera);
    for (int round = 0; round < kRounds; ++round) {
      glm::dvec3 sum(0);
      for (const size_t i : agreeing(cameras, up)) sum += up_of(cameras[i].camera);
      if (glm::length(sum) > 1e-6) up = glm::normalize(sum);
    }
    const size_t count = agreeing(cameras, up).size();
    if (count > most) {
      most = count;
      best = up;
    }
  }
  return best;
}

/// `degrees`: clockwise turn of the images. The filter, unlike the rotation flag, is the same in
/// all versions of FFmpeg.
Finding turned_finding(const CameraRoll& roll, size_t upright, size_t all) {
  const double turn = std::abs(roll.degrees);
  const bool upside_down = turn > 180 - kAlike;
  const bool clockwise = roll.degrees > 0;
  const std::string seen =
      upside_down ? fmt::format("is upside down against {} of {} cameras", upright, all)
                  : fmt::format(
                        "lies on its side against {} of {} cameras, turned {} by {:.0f} "
                        "degrees",
                        upright, all, clockwise ? "clockwise" : "anticlockwise", turn);
  const char* const back = upside_down ? "hflip,vflip" : clockwise ? "transpose=2" : "transpose=1";
  return {Severity::kWarning, "turned", roll.camera, seen,
          fmt::format("where that is not how it was mounted, turn its images back (ffmpeg -i IN "
                      "-vf {} -crf 12 OUT), and with them what --poses states of it, and prepare "
                      "again",
                      back)};
}

}  // namespace

OrientationCheck check_orientation(const Scene& scene) {
  const std::vector<Station> cameras = fixed_cameras(scene);
  OrientationCheck check;
  if (cameras.size() < 2) return check;
  const glm::dvec3 up = common_up(cameras);
  size_t upright = 0;
  for (const Station& station : cameras) {
    check.cameras.push_back(roll_of(station, up));
    const CameraRoll& roll = check.cameras.back();
    upright += roll.known && std::abs(roll.degrees) < kAlike;
  }
  size_t named = 0;
  for (const CameraRoll& roll : check.cameras) {
    const double turn = std::abs(roll.degrees);
    if (!roll.known || turn < kAlike || ++named > kMostNamed) continue;
    check.findings.push_back(turned_finding(roll, upright, cameras.size()));
  }
  return check;
}

std::string mixed_orientation(const std::vector<std::string>& cameras,
                              const std::vector<std::pair<int, int>>& sizes) {
  std::vector<std::string> high;
  size_t wide = 0, first = 0;
  for (size_t i = 0; i < cameras.size(); ++i) {
    wide += sizes[i].first > sizes[i].second;
    if (sizes[i].first >= sizes[i].second) continue;
    if (high.empty()) first = i;
    high.push_back(cameras[i]);
  }
  if (high.empty() || wide == 0) return "";
  return fmt::format("{} {} higher than wide ({}x{}), {} other{} wider than high",
                     listed_names(high), high.size() == 1 ? "is" : "are", sizes[first].first,
                     sizes[first].second, wide, wide == 1 ? " is" : "s are");
}

}  // namespace tessera
