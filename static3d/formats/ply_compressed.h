// What: the compressed .ply of SuperSplat and PlayCanvas: chunks of 256 splats with ranges, 16
//       packed bytes each, optional 8-bit SH.
// Not: the way back from its quantum (11-10-11 bits in a chunk).
// Source: formats 1.2 (the PlayCanvas engine's, MIT), written from its layout.
#pragma once
#include <cstdint>
#include <filesystem>

#include "ingest/files/ply.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

constexpr int64_t kSplatsPerChunk = 256;  // share their ranges

/// Whether the file has the elements of this format.
bool is_compressed_splat(const PlyFile& file);
/// Errors: InputError naming `path` and the element or property that is missing.
GaussianSet decode_compressed_splat(const std::filesystem::path& path, const PlyFile& file);

/// Along a Morton curve, so that chunks are small. Means and logarithms of scales to the range of
/// their chunk by 2047 (y: 1023), opacities and colours to 1/255, SH to 1/32.
void save_compressed_splat(const std::filesystem::path& path, const GaussianSet& set,
                           int sh_degree);

}  // namespace tessera
