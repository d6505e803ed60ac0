// What: the standard 3DGS .ply that every viewer opens, in and out, for Dim 3 sets.
// Not: time: a dynamic model is sliced first (lift.h); what all formats share (splat_file.h).
// Source: [3DGS] reference code's layout; formats: normals zero, f_rest channel-major.
#pragma once
#include <filesystem>

#include "static3d/formats/splat_file.h"

namespace tessera {

/// A .ply of either kind, plain or compressed, as it is. Errors: InputError naming the file and the
/// property that is missing or of a wrong kind.
SplatFile load_ply_splats(const std::filesystem::path& path);
/// Only `float` properties, one element `vertex`, in the order of the reference.
void save_ply_3dgs(const std::filesystem::path& path, const GaussianSet& set, int sh_degree);

}  // namespace tessera
