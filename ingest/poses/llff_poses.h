// Reads and writes poses_bounds.npy of LLFF and N3DV captures. Rows are N × 17: a 3 × 5 row-major
// matrix with the columns [down, right, backward, centre, (height, width, focal)], then near and
// far.
#pragma once
#include <filesystem>
#include <vector>

#include "kernels/base/camera.h"

namespace tessera {

struct LlffPose {
  Camera camera;             // width, height and focal as the row states them; centre in the middle
  double near = 0, far = 0;  // depth bounds, world units
};

/// One entry a row. Errors: InputError naming file and row: not N×17, not finite, no rotation.
std::vector<LlffPose> read_llff_poses(const std::filesystem::path& path);
/// The inverse; fl_x is the focal length that is kept. Errors: InputError when it cannot be
/// written.
void write_llff_poses(const std::filesystem::path& path, const std::vector<LlffPose>& poses);

}  // namespace tessera
