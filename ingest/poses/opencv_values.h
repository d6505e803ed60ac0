// Reads K, D, R and t of OpenCV from a JSON object, in the keys that people give them, as the
// intrinsics, the lens and the pose of a camera. A matrix is nine numbers in rows or without, or
// the object that cv::FileStorage writes. Errors start with where() of the object.
#pragma once
#include <optional>

#include "ingest/poses/intrinsics.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/poses/stated_object.h"
#include "ingest/poses/transforms_values.h"

namespace tessera {

/// K (camera_matrix, mtx, or `intrinsics` as a matrix, in any spelling) and the size of the image
/// (w h, width height, image_width image_height, or imgsize, image_size, resolution: [width,
/// height]); each empty where it is not stated. OpenCV has pixel centres at whole numbers: half a
/// pixel is added to the principal point. Errors: InputError: not nine finite numbers, no camera
/// matrix (skew, a transposed one), a size that is no pixel count.
StatedIntrinsics opencv_intrinsics(const StatedObject& object);

/// D (a list under dist…, distortion… or distCoeff…) of `entry`, else of `file`: 4, 5, 8, 12 or 14
/// numbers k1 k2 p1 p2 k3 k4 k5 k6 …, or k1 to k4 of cv::fisheye where one of them states a
/// fisheye; an empty list is no distortion. Nothing where there is no such key. Errors: InputError:
/// another number of coefficients, thin-prism or tilt coefficients that are not 0, a projection
/// that is neither.
std::optional<StatedLens> opencv_lens(const StatedObject& entry, const StatedObject& file);

/// World to camera in OpenCV axes: R (9 numbers, or a rotation vector of 3, also rvec) and T (t,
/// tvec), or one matrix w2c, extrinsics or RT (3x4, 4x4); camera to world where the key says so
/// (R_c2w and t_c2w, or c2w). Returned as camera to world in OpenGL axes, which set_pose checks.
/// Nothing where there is no such key. Errors: InputError: no finite numbers, R without T.
std::optional<PoseRows> opencv_pose(const StatedObject& object);

}  // namespace tessera
