// Reads single values of a transforms file or of one of its frames: intrinsics, pose, and the lens
// in the keys of Nerfstudio. Errors start with where() of the object.
#pragma once
#include <string>

#include "ingest/files/json_file.h"
#include "ingest/poses/intrinsics.h"
#include "ingest/poses/lens.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/poses/stated_object.h"
#include "kernels/base/similarity.h"

namespace tessera {

/// What this level states. Errors: InputError for what is no finite number or no pixel count.
StatedIntrinsics intrinsics_of(const StatedObject& object);
/// Errors: InputError when lens distortion is stated that is not zero, or a fisheye camera.
void refuse_distortion(const StatedObject& object);
/// The first three rows of the matrix at `key`. Errors: InputError when it is no matrix of numbers,
/// or has a last row that is none of a pose.
PoseRows pose_rows(const StatedObject& frame, const char* key = "transform_matrix");
/// applied.world_transform of a `tessera` object; identity where it states none. Errors: InputError
/// when it is no similarity.
Similarity world_transform_of(const nlohmann::json& object, const std::string& where);

struct StatedLens {
  Lens lens;
  std::string model = "PINHOLE";  // as it is stated; "OPENCV" where only coefficients are
};

/// Of `frame`, or of `file` where the frame has none: camera_model (or is_fisheye), and the
/// coefficients k1 k2 k3 k4 p1 p2, which go together. Perspective models (PINHOLE, SIMPLE_PINHOLE,
/// SIMPLE_RADIAL, RADIAL, OPENCV) have 1 + k1 r² + k2 r⁴ + k3 r⁶ and p1, p2; fisheye models
/// (OPENCV_FISHEYE, RADIAL_FISHEYE, SIMPLE_RADIAL_FISHEYE) k1 to k4 in the angle. Errors:
/// InputError that starts with where() of the frame: another model, a coefficient that the model
/// has not (k4 of a perspective camera has two meanings in use).
StatedLens stated_lens(const StatedObject& frame, const StatedObject& file);

}  // namespace tessera
