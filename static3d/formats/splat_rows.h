// What: .splat: 32 bytes a splat, colours without direction.
// Not: a header: the length alone says how many there are.
// Source: formats 1.3 (antimatter15/splat, MIT), written from its layout.
#pragma once
#include <filesystem>

#include "static3d/formats/splat_file.h"

namespace tessera {

/// Errors: InputError: empty, or a length that is no multiple of 32.
SplatFile load_splat_rows(const std::filesystem::path& path);
/// Largest times most opaque first, as old viewers want it. Spherical harmonics are left out.
void save_splat_rows(const std::filesystem::path& path, const GaussianSet& set);

}  // namespace tessera
