// What: the compressed .ply of SuperSplat and PlayCanvas, read only: chunks of 256 splats with
//       ranges, 16 packed bytes each, optional 8-bit SH.
// Not: a writer; and its quantum (11-10-11 bits in a chunk) is not undone.
// Source: formats of the PlayCanvas engine (MIT), written from its layout.
#pragma once
#include <filesystem>

#include "ingest/files/ply.h"
#include "recon4d/gaussian_set.h"

namespace tessera {

/// Whether the file has the elements of this format.
bool is_compressed_splat(const PlyFile& file);
/// Errors: InputError naming `path` and the element or property that is missing.
GaussianSet decode_compressed_splat(const std::filesystem::path& path, const PlyFile& file);

}  // namespace tessera
