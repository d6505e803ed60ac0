// The manifest of a Tessera 4D file as data, with its conversion from JSON and to JSON. Source:
// docs/reference/tessera4d.md, section 3.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/base/errors.h"
#include "kernels/base/similarity.h"
#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/block_info.h"
#include "static3d/tessera4d/player_hints.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

inline constexpr std::string_view kTessera4dMagic = "TES4";  // of a single file
inline constexpr const char* kTessera4dFormat = "tessera-4d";

/// Errors: InputError naming `path`: a version that readers do not support.
void check_tessera4d_version(const std::filesystem::path& path, uint64_t version);

struct Tessera4dManifest {
  std::string generator;
  std::array<double, 3> up{0, -1, 0};                // unit length
  double fps = 0;                                    // of the capture; 0: not known
  std::optional<std::array<Vec3<float>, 2>> bounds;  // of the means, outliers left aside
  int64_t non_finite = 0, never_drawn = 0;           // left out
  int64_t far_outliers = 0;                          // written
  bool anchor_in_clip = true, lossless = false;
  std::vector<PlayerCamera> cameras;
  std::string audio;
  std::vector<FileWindow> windows;  // none: one time, that of the clip
  std::vector<BlockInfo> blocks;

  /// Of dynamic blocks, or of all others.
  int64_t gaussians(bool moving) const;
  /// Of the block that motion nodes carry.
  int64_t canonical() const;
  /// The most that are drawn at a time: all that are not dynamic, and those of one window.
  int64_t peak() const;
  uint32_t version() const;
};

/// `rules`: a model of no Gaussians that states how they are drawn, their SH degree and their
/// clock.
nlohmann::json to_json(const Tessera4dManifest& manifest, const GaussianModel& rules);
/// The way back, into `rules` too. Errors: InputError naming `path`, what is wrong and the remedy:
/// no JSON, another format, a newer version, numbers that cannot be.
Tessera4dManifest manifest_from(const nlohmann::json& json, const std::filesystem::path& path,
                                GaussianModel& rules);

}  // namespace tessera
