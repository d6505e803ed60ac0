// What: the standard 3DGS .ply that every viewer opens, in and out, for Dim 3 sets.
// Not: time: a dynamic model is sliced first (lift.h).
// Source: [3DGS] reference code's layout; formats: normals zero, f_rest channel-major.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "recon4d/gaussian_set.h"

namespace tessera {

struct Ply3dgs {
  GaussianSet set{Form::kStatic, kMaxShCoefficients};
  int sh_degree = 0;
  std::vector<std::string> warnings;  // unknown properties, quaternions that were normalised, …
};

/// Errors: InputError naming the file and the property that is missing or of a wrong kind.
Ply3dgs load_ply_3dgs(const std::filesystem::path& path);
/// Only `float` properties, one element `vertex`, unit quaternions, in the order of the reference.
/// `sh_degree` bands are written. Non-finite Gaussians are left out; returns how many were.
int64_t save_ply_3dgs(const std::filesystem::path& path, const GaussianSet& set, int sh_degree);

}  // namespace tessera
