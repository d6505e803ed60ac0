// Files of static Gaussians in the formats of other programs: reading by content, writing by the
// name of a format.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// What a file of splats says of how they are drawn.
struct SplatDrawing {
  int sh_degree = 0;
  bool antialiased = false;  // DrawingRules::filter_2d, which viewers call mip
};

/// What a file of splats holds.
struct SplatFile {
  GaussianSet set{SetForm::kStatic, kMaxShCoefficients};
  SplatDrawing drawing;
  std::vector<std::string> warnings;  // unknown properties, quaternions that were normalised, …
};

struct SplatFormat {
  const char* name;       // of --format
  const char* extension;  // ".ply"
  const char* doc;        // one line: what is lost, which programs read it
  /// Of sound Gaussians with unit quaternions. Returns how many were left out because they are too
  /// far from the others for the range of the format. Errors: InputError: what it cannot hold.
  int64_t (*save)(const std::filesystem::path&, const GaussianSet&, const SplatDrawing&);
  bool has_mark = true;  // states SplatDrawing::antialiased, which viewers read
};
const std::vector<SplatFormat>& splat_formats();
/// Errors: InputError naming the nearest known name.
const SplatFormat& splat_format(const std::string& name);
/// .spz of version 3 (that of splat_formats) or 4. Errors: InputError: another version.
SplatFormat spz_format(int version);

/// Makes quaternions unit; returns how many were not of length 1.
int64_t normalise_rotations(GaussianSet& set);

/// Whether load_splat_file reads a file with that name and these first bytes.
bool is_splat_file(const std::filesystem::path& path, std::string_view head);
/// 3DGS .ply, compressed .ply, .spz of versions 2 to 4, .sog, .splat, .glb. Only sound Gaussians,
/// unit quaternions. Errors: InputError naming the file, what is wrong and the remedy.
SplatFile load_splat_file(const std::filesystem::path& path);

/// Writes the first `drawing.sh_degree` degrees. Non-finite Gaussians are left out, and those that
/// are too far for the format; returns how many were.
int64_t save_splat_file(const SplatFormat& format, const std::filesystem::path& path,
                        const GaussianSet& set, const SplatDrawing& drawing);
/// A model at one time, of what was read.
GaussianModel model_of(SplatFile file);

}  // namespace tessera
