// Camera placement: a forward-facing rig for video, and pose sequences for one camera.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "kernels/base/camera.h"
#include "tools/synth/synth.h"

namespace tessera::synth {

/// A pinhole camera at `eye` that looks at `target`, z up in the image; `angle` is the
/// horizontal field of view, radians.
Camera look_at(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
               double angle);

/// Camera-to-world with OpenGL axes (x right, y up, z backward), rows of a 4 × 4 matrix.
std::array<std::array<double, 4>, 4> opengl_pose(const Camera& camera);

/// Horizontal field of view of a scene's cameras, radians.
double field_of_view(SynthScene scene);

/// Cameras on two rows of an arc that faces `target`; camera 0 stands in the middle of the others.
std::vector<Camera> video_rig(const SynthOptions& options, const glm::dvec3& target);

enum class PoseSet { kTrain, kVal, kTest };

/// One camera a view for the monocular layout: well spread (train, val) or one sweep (test).
std::vector<Camera> monocular_poses(const SynthOptions& options, const glm::dvec3& target,
                                    PoseSet set, int count);

}  // namespace tessera::synth
