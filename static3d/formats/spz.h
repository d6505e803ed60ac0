// What: .spz of Niantic: quantised columns in one gzip stream (versions 2, 3) or one zstd stream
//       each (version 4), in a right-up-back world.
// Not: version 1, whose positions are half floats, and extensions, which are passed over.
// Source: formats 1.5 (nianticlabs/spz, MIT), written from its layout.
#pragma once
#include <filesystem>
#include <string_view>

#include "static3d/formats/splat_file.h"

namespace tessera {

/// Whether a file that starts so is one.
bool is_spz(std::string_view head);
/// Errors: InputError: another version, cut off, damaged, counts that do not fit.
SplatFile load_spz(const std::filesystem::path& path);
/// Version 3, which most players read, or 4. Means to 1/4096 of a unit within ±2048, logarithms of
/// scales to 1/16, opacities and colours to 1/255, SH to 1/16 (first degree) and 1/8. Errors:
/// InputError: a mean out of range; version 4 in a build without zstd.
void save_spz(const std::filesystem::path& path, const GaussianSet& set, int sh_degree,
              int version = 3);

}  // namespace tessera
