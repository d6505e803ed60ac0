// Converts camera-to-world matrices in OpenGL axes (x right, y up, z back) to the convention of
// Camera and back: c2w of Camera = c2w_gl · diag(1, −1, −1, 1), inverted rigidly.
#pragma once
#include <array>
#include <string>

#include "kernels/base/camera.h"

namespace tessera {

using PoseRows = std::array<std::array<double, 4>, 3>;  // [row][column]: rotation | centre

/// Sets cam_from_world and translation. Deviations from a rotation up to 1e-3 are removed in
/// double (polar decomposition). Errors: InputError that starts with `where`: a value that is not
/// finite, a block that is singular, mirrored or scaled.
void set_pose(Camera& camera, const PoseRows& world_from_gl_camera, const std::string& where);

/// The inverse of set_pose.
PoseRows gl_pose_of(const Camera& camera);

}  // namespace tessera
