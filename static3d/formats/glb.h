// What: .glb with KHR_gaussian_splatting, written: one primitive of points in floats, in a
//       left-up-front world.
// Not: a reader, and no compression.
// Source: formats 1.7 (Khronos, ratified), written from its layout.
#pragma once
#include <filesystem>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Exact but for exp(ln scale) and σ(logit). Errors: InputError: more bytes than 32 bits count.
void save_glb(const std::filesystem::path& path, const GaussianSet& set, int sh_degree);

}  // namespace tessera
