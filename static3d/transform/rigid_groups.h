// A canonical set as groups of Gaussians that move rigidly, for formats whose nodes carry meshes: a
// group is what one motion node carries most, or a part of that which two nodes share. The motion
// of a group is the blend of the nodes by the mean weights of its Gaussians. Source: method D.9
// (kernels/math/carry.h), whose blend is not rigid in general; the difference is measured.
#pragma once
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// x ↦ R(rotation)·x + translation, from the frame of a group to the world.
struct RigidPose {
  Vec4<double> rotation{1, 0, 0, 0};  // unit quaternion w,x,y,z; consecutive ones have a dot ≥ 0
  Vec3<double> translation{};         // world units
};

struct RigidGroup {
  std::vector<int64_t> members;  // elements, ascending
  std::vector<RigidPose> poses;  // one for each time; at the reference the rotation is none
};

struct RigidGroups {
  std::vector<int64_t> fixed;  // elements that no node carries, ascending
  std::vector<RigidGroup> groups;
  /// The set at the reference time, of form kStatic, with the means of each group in its own frame:
  /// there the groups are exact.
  GaussianSet local{SetForm::kStatic, 1};
  double rms_error = 0;  // world units, of means of carried Gaussians over all times
};

/// `set`: canonical, of valid elements. `times`: normalised, ascending, at least one; the middle
/// one is the reference. `most`: groups, at least 1; the smallest are merged into that of the
/// nearest node.
RigidGroups rigid_groups(const GaussianSet& set, const MotionNodes& nodes,
                         const std::vector<double>& times, int64_t most = 256);

}  // namespace tessera
