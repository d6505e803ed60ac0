// Readers and writers of the single formats of splat_file.h. The .cpp file of each format has its
// layout and source.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "ingest/files/ply.h"
#include "recon4d/model/gaussian_set.h"
#include "static3d/formats/splat_file.h"

namespace tessera {

/// Of a .ply, as Brush writes it and splat-transform, gsplat and nerfstudio read it.
inline constexpr const char* kAntialiasedComment = "SplatRenderMode: mip";

/// The extension of glTF, and how the names of its attributes begin.
inline const std::string kGlbExtension = "KHR_gaussian_splatting";

/// A .ply of either kind, plain or compressed, as it is. Errors: InputError naming the file and the
/// property that is missing or of a wrong kind.
SplatFile load_ply_splats(const std::filesystem::path& path);
/// Only `float` properties, one element `vertex`, in the order of the reference.
/// Of antialiased splats the comment "SplatRenderMode: mip" of Brush; Postshot's "antialiased 1" is
/// read, too.
void save_ply_3dgs(const std::filesystem::path& path, const GaussianSet& set,
                   const SplatDrawing& drawing);

/// Whether the file has the elements of this format.
bool is_compressed_splat(const PlyFile& file);
/// Errors: InputError naming `path` and the element or property that is missing.
GaussianSet decode_compressed_splat(const std::filesystem::path& path, const PlyFile& file);

/// Along a Morton curve, so that chunks are small. Means and logarithms of scales to the range of
/// their chunk by 2047 (y: 1023), opacities and colours to 1/255, SH to 1/32. Leaves out what would
/// widen the chunk of others, see rows_in_chunks; returns how many.
int64_t save_compressed_splat(const std::filesystem::path& path, const GaussianSet& set,
                              const SplatDrawing& drawing);

/// Errors: InputError: empty, or a length that is no multiple of 32.
SplatFile load_splat_rows(const std::filesystem::path& path);
/// Largest times most opaque first, as old viewers expect it. Spherical harmonics are left out.
void save_splat_rows(const std::filesystem::path& path, const GaussianSet& set);

/// Whether a file that starts so is one.
bool is_spz(std::string_view head);
/// Errors: InputError: another version, cut off, damaged, counts that do not fit.
SplatFile load_spz(const std::filesystem::path& path);
/// Version 3, which most players read, or 4. Means to 1/4096 of a unit within ±2047, logarithms of
/// scales to 1/16, opacities and colours to 1/255, SH to 1/16 (first degree) and 1/8. Where more
/// than one in a hundred is beyond ±2047 the step of means is doubled, and again. Leaves out what
/// is still beyond; returns how many. Errors: InputError: a scene too small for its distance from
/// the origin; version 4 in a build without zstd.
int64_t save_spz(const std::filesystem::path& path, const GaussianSet& set,
                 const SplatDrawing& drawing, int version = 3);

/// By its first bytes a zip archive with the images. Errors: InputError: another version, cut off,
/// damaged, compressed entries, a build without libwebp.
SplatFile load_sog(const std::filesystem::path& path);
/// Logarithms of means to 1/65535 of their range, ln scales and colours by codebooks of 256
/// numbers, opacities to 1/255, SH by a palette. Leaves out what would widen the range so far that
/// the core of the scene is off by more than 1/256 of its half extent; returns how many. Errors:
/// InputError: a build without libwebp.
int64_t save_sog(const std::filesystem::path& path, const GaussianSet& set,
                 const SplatDrawing& drawing);

/// Whether a file that starts so is one.
bool is_glb(std::string_view head);
/// One primitive of KHR_gaussian_splatting. Errors: InputError: none, several, compressed ones,
/// attributes that are missing, damaged, or beyond the file.
SplatFile load_glb(const std::filesystem::path& path);
/// Exact but for exp(ln scale) and σ(logit). Errors: InputError: more bytes than 32 bits count.
void save_glb(const std::filesystem::path& path, const GaussianSet& set, int sh_degree);

}  // namespace tessera
