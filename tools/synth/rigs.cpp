// Rigs and pose sequences follow from the options alone. All cameras are ideal pinholes without
// lens distortion.
#include "tools/synth/rigs.h"

#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "ingest/poses/pose_matrix.h"
#include "tools/synth/hash.h"

namespace tessera::synth {
namespace {

using glm::dvec3;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kBlenderAngle = 0.6911112070083618;  // camera_angle_x of D-NeRF's scenes

/// A point at `radius` from the target; azimuth 0 is in front (−y), height an angle.
dvec3 around(const dvec3& target, double radius, double azimuth, double elevation) {
  return target + radius * dvec3(std::cos(elevation) * std::sin(azimuth),
                                 -std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
}

/// Van der Corput's sequence in base 2: each new point falls into the largest gap.
double spread(uint32_t index) {
  double value = 0, share = 0.5;
  for (; index != 0; index >>= 1, share *= 0.5) value += share * (index & 1);
  return value;
}

/// Azimuth and elevation of view `index`, both filling (0, 1) evenly at any length of sequence.
struct SpreadPair {
  double first, second;
};
SpreadPair spread_pair(const SynthOptions& options, PoseSet set, int index) {
  const uint32_t start = hash(uint32_t(options.seed), int(set), 5);
  const double golden = 0.6180339887498949 * index + unit(start);
  return {golden - std::floor(golden), spread(uint32_t(index) + 1 + 64 * uint32_t(set))};
}

/// Free viewpoints in the front of the room.
dvec3 room_eye(const dvec3& target, double across, double up, double along) {
  return around(target, 3.7 + 0.5 * along, (2 * across - 1) * 32 * kDegree,
                (-4 + 26 * up) * kDegree);
}

}  // namespace

Camera look_at(const dvec3& eye, const dvec3& target, int width, int height, double angle) {
  const dvec3 forward = glm::normalize(target - eye);
  const dvec3 right = glm::normalize(glm::cross(forward, dvec3(0, 0, 1)));
  const dvec3 down = glm::cross(forward, right);
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fl_x = camera.fl_y = 0.5 * width / std::tan(0.5 * angle);
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  camera.cam_from_world = glm::transpose(glm::dmat3(right, down, forward));
  camera.translation = -(camera.cam_from_world * eye);
  return camera;
}

std::array<std::array<double, 4>, 4> opengl_pose(const Camera& camera) {
  const PoseRows rows = gl_pose_of(camera);
  return {{rows[0], rows[1], rows[2], {0, 0, 0, 1}}};
}

double field_of_view(SynthScene scene) {
  return is_on_nothing(scene) ? kBlenderAngle : 60 * kDegree;
}

std::vector<Camera> video_rig(const SynthOptions& options, const dvec3& target) {
  const double angle = field_of_view(options.scene);
  std::vector<Camera> cameras;
  const int others = options.cameras - 1, columns = (others + 1) / 2;
  for (int i = 0; i < options.cameras; ++i) {
    double azimuth = 0, elevation = 9 * kDegree;
    if (i > 0) {
      const int column = (i - 1) / 2, in_row = (i - 1) % 2 == 0 ? columns : others - columns;
      const double along = in_row > 1 ? double(column) / (in_row - 1) : 0.5;
      azimuth = (2 * along - 1) * 27 * kDegree;
      elevation = ((i - 1) % 2 == 0 ? 2 : 16) * kDegree;
    }
    const uint32_t h = hash(uint32_t(options.seed), i, 6);
    azimuth += 0.4 * kDegree * signed_unit(h);  // a hand-built rig is not exact
    elevation += 0.4 * kDegree * signed_unit(mix(h));
    const double radius = 4.0 + 0.05 * signed_unit(mix(h + 1));
    cameras.push_back(look_at(around(target, radius, azimuth, elevation), target, options.width,
                              options.height, angle));
  }
  return cameras;
}

std::vector<Camera> monocular_poses(const SynthOptions& options, const dvec3& target, PoseSet set,
                                    int count) {
  const double angle = field_of_view(options.scene);
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const SpreadPair pair = spread_pair(options, set, i);
    const double sweep = (i + 0.5) / count;
    const bool test = set == PoseSet::kTest;
    dvec3 eye;
    if (is_on_nothing(options.scene)) {
      const double azimuth = 2 * std::numbers::pi * (test ? sweep : pair.first);
      // Sines of elevations are even by area of the sphere; a tall figure is not seen from the top.
      const bool tall = options.scene == SynthScene::kFigure;
      const double height = test ? (tall ? 0.3 : 0.5) : 0.08 + (tall ? 0.47 : 0.82) * pair.second;
      eye = around(target, 4.0, azimuth, std::asin(height));
    } else {
      eye = test ? room_eye(target, sweep, 0.45, 0.3)
                 : room_eye(target, pair.first, pair.second, unit(hash(uint32_t(i), int(set), 7)));
    }
    cameras.push_back(look_at(eye, target, options.width, options.height, angle));
  }
  return cameras;
}

}  // namespace tessera::synth
