// The 4D splat files of other programs, each of which holds a clip as lines. The .cpp file of a
// format has its layout and source.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/files/ply.h"
#include "recon4d/model/gaussian_set.h"
#include "static3d/formats/sog_archive.h"

namespace tessera {

/// Frames a second of a capture or file that states none, and frames of a file that states none.
inline constexpr double kUnstatedRate = 30, kUnstatedFrames = 300;

/// What a file of lines holds.
struct LineFile {
  GaussianModel model;
  std::vector<std::string> warnings;  // one line each
};

struct LineFormat {
  const char* name;       // of --format
  const char* extension;  // ".ftgs.ply"
  const char* doc;        // one line: what is lost, which programs read it
  /// Of a model of lines.h. `fps`: of the capture; 0: not known. Returns how many Gaussians were
  /// left out because they are too far from the others for the range of the format. Errors:
  /// InputError: what it cannot hold, a build without libwebp.
  int64_t (*save)(const std::filesystem::path&, const GaussianModel&, double fps);
  bool is_read = true;  // by load_line_file
};
const std::vector<LineFormat>& line_formats();
/// Nothing: no format of lines has that name.
const LineFormat* find_line_format(std::string_view name);

/// Whether load_line_file reads the file, by its first bytes.
bool is_line_file(const std::filesystem::path& path);
/// Errors: InputError naming the file, what is wrong and the remedy.
LineFile load_line_file(const std::filesystem::path& path);

/// FTGS PLY, version 1. Source: "FTGS PLY, version 1" of ftgs-player.
int64_t save_ftgs_ply(const std::filesystem::path& path, const GaussianModel& model, double fps);
LineFile load_ftgs_ply(const std::filesystem::path& path, const PlyFile& file);

/// The interchange PLY of .sogst. Source: "The .sogst format", revision 14, section 7.
int64_t save_sogst_ply(const std::filesystem::path& path, const GaussianModel& model, double fps);
LineFile load_sogst_ply(const std::filesystem::path& path, const PlyFile& file);

int64_t save_sogst(const std::filesystem::path& path, const GaussianModel& model, double fps);
LineFile load_sogst(const std::filesystem::path& path, const SogArchive& archive);

int64_t save_tsog(const std::filesystem::path& path, const GaussianModel& model, double fps);
LineFile load_tsog(const std::filesystem::path& path, const SogArchive& archive);

/// SpacetimeGaussians, whose Gaussians move along curves.
LineFile load_spacetime_ply(const std::filesystem::path& path, const PlyFile& file);

int64_t save_usda(const std::filesystem::path& path, const GaussianModel& model, double fps);

}  // namespace tessera
