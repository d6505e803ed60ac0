// What: the values of a transforms file or of one of its frames: intrinsics, pose, distortion.
// Not: the file's structure (transforms_json.h). Internal to the parser; errors start with `where`.
#pragma once
#include <string>

#include "ingest/files/json_file.h"
#include "ingest/poses/intrinsics.h"
#include "ingest/poses/pose_matrix.h"
#include "kernels/base/similarity.h"

namespace tessera {

/// True where `key` is there and is true.
bool is_true(const nlohmann::json& object, const char* key);
/// What this level states. Errors: InputError for what is no finite number or no pixel count.
StatedIntrinsics intrinsics_of(const nlohmann::json& object, const std::string& where);
/// Errors: InputError when lens distortion is stated that is not zero, or a fisheye camera.
void refuse_distortion(const nlohmann::json& object, const std::string& where);
/// The first three rows of transform_matrix. Errors: InputError when it is no matrix of numbers.
PoseRows pose_rows(const nlohmann::json& frame, const std::string& where);
/// applied.world_transform of a `tessera` object; identity where it states none. Errors: InputError
/// when it is no similarity.
Similarity world_transform_of(const nlohmann::json& object, const std::string& where);

}  // namespace tessera
