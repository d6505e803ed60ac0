// Writer and reader of the Tessera 4D file: a model in continuous time, divided into segments that
// a player fetches as it needs them. Source: docs/reference/tessera4d.md.
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/manifest.h"

namespace tessera {

struct Tessera4dOptions {
  double segment_seconds = 1;  // of level 1
  bool lossless = false;
  int gzip_level = 12;  // 1 to 12
  double fps = 0;       // of the capture, for players that step by frames; 0: not known
  std::vector<PlayerCamera> cameras;  // in the model's world
  std::string audio;                  // beside the manifest
  std::string generator = "tessera";
};

/// Gaussians of a file, and those of the model that are not in it.
struct Tessera4dCounts {
  int64_t static_count = 0, dynamic_count = 0, non_finite = 0, never_drawn = 0, far_outliers = 0;
};

/// A file that has not been written yet.
struct Tessera4dFile : Tessera4dCounts {
  std::string manifest;                                     // JSON
  std::vector<std::pair<std::string, std::string>> blocks;  // name, bytes

  /// Of manifest and blocks.
  int64_t bytes() const;
};

/// Environments and levels of time are not held: the former are left out, colours that follow time
/// are those of each Gaussian's own timestep. Errors: InputError: a segment of no length.
Tessera4dFile encode_tessera4d(const GaussianModel& model, const Tessera4dOptions& options);

constexpr const char* kTessera4dManifest = "manifest.json";
/// manifest.json, last, and the blocks, each atomically. Errors: InputError: the folder.
void write_tessera4d_folder(const std::filesystem::path& folder, const Tessera4dFile& file);
/// The same as the bytes of one file.
std::string single_tessera4d(const Tessera4dFile& file);
/// A folder as one file, block by block, atomically. Errors: InputError naming the file, what is
/// wrong, the remedy.
void single_from_folder(const std::filesystem::path& folder, const std::filesystem::path& path);

/// Whether the first bytes are those of a single file; whether a folder's manifest.json names the
/// format.
bool is_tessera4d(std::string_view head);
bool is_tessera4d_folder(const std::filesystem::path& folder);

}  // namespace tessera
