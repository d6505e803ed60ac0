// Properties of a rig of cameras: the extent of the scene, the point at which the cameras look, and
// whether a camera sees a point. Source: method A.2 (scene extent, carving).
#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "kernels/base/camera.h"

namespace tessera {

struct CameraRig {
  std::vector<Camera> cameras;  // distinct ones
  double extent = 0;            // E = 1.1 · max ‖C_i − mean C‖, world units; never 0
  glm::dvec3 focus{0.0};        // point nearest to all viewing axes
  double distance = 0;          // median distance of a camera to `focus`
  double half_view = 0;         // distance · tan(half the largest field of view)
};

/// `cameras`: one or more, of any number of frames; equal ones count once.
CameraRig make_camera_rig(const std::vector<Camera>& cameras);

/// Between two cameras seen from the focus, degrees.
double angle_at_focus(const CameraRig& rig, const Camera& a, const Camera& b);

/// Median over the cameras of the angle at the focus to the second-nearest other one, degrees; 0 of
/// two or fewer.
double neighbour_angle(const CameraRig& rig);

/// Whether the point lies in front of the near plane and inside the image.
bool sees(const Camera& camera, const glm::dvec3& point, double near_plane);

}  // namespace tessera
