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
#include "static3d/tessera4d/player_hints.h"

namespace tessera {

inline constexpr std::string_view kTessera4dMagic = "TES4";  // of a single file
inline constexpr const char* kTessera4dFormat = "tessera-4d";
/// Of files without motion nodes, and of those with them; readers support both.
inline constexpr uint32_t kTessera4dVersion = 1, kTessera4dNodesVersion = 2;

/// Errors: InputError naming `path`: a version that readers do not support.
void check_tessera4d_version(const std::filesystem::path& path, uint64_t version);

enum class StreamType { kU8, kU16, kU24, kU32, kF32 };

/// Bytes of one number of a stream.
int bytes_of(StreamType type);

struct StreamInfo {
  std::string name;
  StreamType type = StreamType::kU8;
  int components = 1;
  int64_t count = 0;  // Gaussians, from the first of the block; nodes or their control points
  std::vector<double> scale, bias;  // [components] of integers
  bool delta = false, gzip = true;
  uint64_t offset = 0, bytes = 0;  // within the block
};

/// From one timestep to another, normalised time.
struct Interval {
  double low = 0, high = 1;
};

struct BlockInfo {
  bool moving = false;
  std::string file;     // of a folder
  uint64_t offset = 0;  // of a single file, from the first byte behind the manifest
  uint64_t bytes = 0;
  uint32_t crc32 = 0;
  Interval visible, segment;
  int level = 0;
  int64_t count = 0;
  int64_t nodes = 0;  // of a canonical block: motion nodes, and the control points of each
  int knots = 0;
  std::vector<StreamInfo> streams;
};

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
  std::vector<BlockInfo> blocks;

  /// Of dynamic blocks, or of all others.
  int64_t gaussians(bool moving) const;
  /// Of the block that motion nodes carry.
  int64_t canonical() const;
  uint32_t version() const { return canonical() > 0 ? kTessera4dNodesVersion : kTessera4dVersion; }
};

/// `rules`: a model of no Gaussians that states how they are drawn, their SH degree and their
/// clock.
nlohmann::json to_json(const Tessera4dManifest& manifest, const GaussianModel& rules);
/// The way back, into `rules` too. Errors: InputError naming `path`, what is wrong and the remedy:
/// no JSON, another format, a newer version, numbers that cannot be.
Tessera4dManifest manifest_from(const nlohmann::json& json, const std::filesystem::path& path,
                                GaussianModel& rules);

}  // namespace tessera
