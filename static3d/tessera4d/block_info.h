// Which Gaussians a block of a Tessera 4D file has and where its streams lie, with the conversion
// from JSON and to JSON. Source: docs/reference/tessera4d.md, section 3.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "static3d/tessera4d/windows.h"

namespace tessera {

/// Of files without motion nodes, of those with them, and of those of windows; readers support all.
inline constexpr uint32_t kTessera4dVersion = 1, kTessera4dNodesVersion = 2,
                          kTessera4dWindowsVersion = 3;

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
  uint64_t offset = 0, bytes = 0;  // within the block, from behind its head
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
  uint64_t head =
      0;            // bytes of JSON in front, which then has the streams; 0: the manifest has them
  int window = -1;  // of a dynamic block of a file of windows
  std::vector<StreamInfo> streams;
};

nlohmann::json to_json(const BlockInfo& block);
/// `windows`: of the file, as many as there are. Errors: InputError naming `path`.
BlockInfo block_from(const nlohmann::json& object, uint64_t version, size_t windows,
                     const std::filesystem::path& path);

/// The streams of a block as the JSON of its head, and the block's streams from the head that
/// `bytes` begin with. Errors: InputError naming `path`: no JSON, values that cannot be.
std::string head_of(const BlockInfo& block);
std::vector<StreamInfo> streams_of_head(std::string_view bytes, const BlockInfo& block,
                                        const std::filesystem::path& path);

}  // namespace tessera
