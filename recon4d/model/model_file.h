// What: a GaussianModel as a file: the Tessera 4D .ply, which reloads bit-equal.
// Not: optimizer state (checkpoint.h) and not the 3DGS .ply of other programs
// (static3d/formats/ply_3dgs.h).
#pragma once
#include <filesystem>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Elements `vertex` (static set, standard 3DGS columns) and `vertex_dynamic` (the same plus
/// mean_time, scale_time, rot_right_0..3 or velocity_0..2, and f_cos1_*, f_cos2_* where colours
/// follow time); stored parameters unchanged; comments carry the version, time axis,
/// background, train_scale, prepared_from_source and each drawing rule by its name; with an
/// environment also an element of that name, one row a texel. Written atomically.
void save_model(const std::filesystem::path& path, const GaussianModel& model);
/// Errors: InputError naming the file and what is missing. `is_tessera_model` tells beforehand.
GaussianModel load_model(const std::filesystem::path& path);
/// Whether the .ply carries Tessera's comment (a plain 3DGS .ply does not).
bool is_tessera_model(const std::filesystem::path& path);

}  // namespace tessera
