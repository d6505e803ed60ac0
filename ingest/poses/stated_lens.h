// What: the lens that a transforms.json states (Nerfstudio's keys), at two levels → Lens.
// Not: COLMAP's parameter lists (colmap_camera.h).
#pragma once
#include <string>

#include "ingest/files/json_file.h"
#include "ingest/poses/lens.h"

namespace tessera {

struct StatedLens {
  Lens lens;
  std::string model = "PINHOLE";  // as it is stated; "OPENCV" where only coefficients are
};

/// Of `frame`, level by level of `file` where it is silent: camera_model (or is_fisheye), and the
/// coefficients k1 k2 k3 k4 p1 p2, which go together. Perspective models (PINHOLE, SIMPLE_PINHOLE,
/// SIMPLE_RADIAL, RADIAL, OPENCV) have 1 + k1 r² + k2 r⁴ + k3 r⁶ and p1, p2; fisheye models
/// (OPENCV_FISHEYE, RADIAL_FISHEYE, SIMPLE_RADIAL_FISHEYE) k1 to k4 in the angle. Errors:
/// InputError that starts with `where`: another model, a coefficient that the model has not (k4 of
/// a perspective camera means two things in the field).
StatedLens stated_lens(const nlohmann::json& frame, const nlohmann::json& file,
                       const std::string& where);

}  // namespace tessera
