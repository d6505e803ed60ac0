// A pinhole camera and a view (camera and time), in double, as scenes hold them. Ingest has removed
// distortion. Camera axes are +x right, +y down, +z forward; pixel centres are at +0.5 (COLMAP's
// convention).
#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace tessera {

struct Camera {
  int width = 0;              // pixels
  int height = 0;             // pixels
  double fl_x = 0, fl_y = 0;  // focal lengths, pixels
  double cx = 0, cy = 0;      // principal point, pixels from the left/top edge of the image
  // Of a rolling shutter: by how much later the bottom row is exposed than the top one, normalised
  // time; negative where the bottom comes first. The middle one has the time of the view.
  double readout = 0;
  // x_in_cam = cam_from_world * x_in_world + translation. glm is column-major: m[column][row].
  glm::dmat3 cam_from_world{1.0};
  glm::dvec3 translation{0.0};

  bool operator==(const Camera&) const = default;
  /// Whether the two stand in one place and look the same way, to the bit.
  friend bool equal_pose(const Camera& a, const Camera& b) {
    return a.cam_from_world == b.cam_from_world && a.translation == b.translation;
  }

  /// Camera centre in world units.
  glm::dvec3 position() const { return -(glm::transpose(cam_from_world) * translation); }

  /// The same camera for an image resampled to `new_width` × `new_height`: rays are unchanged.
  Camera resized(int new_width, int new_height) const {
    const double sx = double(new_width) / width, sy = double(new_height) / height;
    Camera scaled = *this;
    scaled.width = new_width;
    scaled.height = new_height;
    scaled.fl_x *= sx;
    scaled.cx *= sx;
    scaled.fl_y *= sy;
    scaled.cy *= sy;
    return scaled;
  }
};

/// A camera at a time. `time` is normalised: 0 is the first, 1 the last timestep of the scene.
struct View {
  Camera camera;
  double time = 0;
  int32_t timestep = 0, series = 0;  // their numbers in a scoring pass, for measures over time
};

}  // namespace tessera
