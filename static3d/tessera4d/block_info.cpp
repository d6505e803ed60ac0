// Streams and blocks as JSON, in the manifest or in the head of a block; every value is checked
// before it is used.
#include "static3d/tessera4d/block_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "kernels/math/node_pose.h"
#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/checked_object.h"
#include "static3d/tessera4d/node_streams.h"

namespace tessera {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr uint64_t kMost = uint64_t{1} << 40;         // bytes
constexpr int64_t kMostGaussians = int64_t{1} << 28;  // of a block
constexpr const char* kTypeNames[] = {"u8", "u16", "u24", "u32", "f32"};

json to_json(const StreamInfo& stream) {
  json out = {{"name", stream.name},
              {"type", kTypeNames[int(stream.type)]},
              {"components", stream.components},
              {"count", stream.count},
              {"codec", stream.gzip ? "gzip" : "none"},
              {"offset", stream.offset},
              {"bytes", stream.bytes}};
  if (!stream.scale.empty()) {
    out["scale"] = stream.scale;
    out["bias"] = stream.bias;
  }
  if (stream.delta) out["delta"] = true;
  return out;
}

/// Streams that this version reads; others are for newer readers.
bool is_known(const std::string& name) {
  constexpr const char* kNames[] = {"position",
                                    "rotation",
                                    "log_scale",
                                    "opacity",
                                    "colour",
                                    "sh1",
                                    "sh2",
                                    "sh3",
                                    "velocity",
                                    "time_mean",
                                    "log_time_scale",
                                    "opacity_logit",
                                    "rotation_largest",
                                    "node",
                                    "node_weight",
                                    "node_logit",
                                    "node_position",
                                    "node_translation",
                                    "node_rotation",
                                    "node_log_radius"};
  return std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
}

StreamInfo stream_from(const json& object, const BlockInfo& block, const fs::path& path) {
  const CheckedObject reading(object, path, "a stream");
  StreamInfo stream;
  stream.name = reading.text("name");
  const std::string type = reading.text("type"), codec = reading.text("codec");
  const auto known = std::find(std::begin(kTypeNames), std::end(kTypeNames), type);
  if (known == std::end(kTypeNames) || (codec != "gzip" && codec != "none"))
    reading.fail(fmt::format("'{}' has type '{}' and codec '{}', which this version cannot read",
                             stream.name, type, codec));
  stream.type = StreamType(known - std::begin(kTypeNames));
  stream.gzip = codec == "gzip";
  constexpr uint64_t kMostComponents = 64;
  stream.components = int(reading.whole("components", kMostComponents));
  const int64_t rows = node_rows(stream.name, block.nodes, block.knots);
  stream.count = int64_t(reading.whole("count", uint64_t(rows > 0 ? rows : block.count)));
  stream.delta = reading.flag_or("delta", false);
  stream.offset = reading.whole("offset", block.bytes);
  stream.bytes = reading.whole("bytes", block.bytes - stream.offset);
  if (stream.type != StreamType::kF32) {
    stream.scale = reading.numbers("scale", size_t(stream.components));
    stream.bias = reading.numbers("bias", size_t(stream.components));
  }
  return stream;
}

/// Those of a list that this version reads.
std::vector<StreamInfo> streams_from(const json& list, const BlockInfo& block,
                                     const fs::path& path) {
  std::vector<StreamInfo> streams;
  for (const json& stream : list)
    if (is_known(CheckedObject(stream, path, "a stream").text("name")))
      streams.push_back(stream_from(stream, block, path));
  return streams;
}

/// A name inside the folder, not a way out of it.
std::string plain_name(const CheckedObject& block) {
  const std::string name = block.text("file");
  if (name.empty() || name.find_first_of("/\\") != std::string::npos || name == "..")
    block.fail(fmt::format("has file '{}', expected a plain name", name));
  return name;
}

/// Of a file of windows: the block's window and the size of its head.
void read_window(const CheckedObject& object, size_t windows, BlockInfo& block) {
  block.head = object.whole("head", kMost);
  if (block.head == 0 || block.head > block.bytes)
    object.fail(fmt::format("has a head of {} bytes in {}", block.head, block.bytes));
  if (!block.moving) {
    if (object.has("window")) object.fail("is static and has a 'window'");
    return;
  }
  const uint64_t window = object.whole("window", kMost);
  if (window >= windows)
    object.fail(fmt::format("belongs to window {}, the file has {}", window, windows));
  block.window = int(window);
}

}  // namespace

int bytes_of(StreamType type) {
  switch (type) {
    case StreamType::kU8:
      return 1;
    case StreamType::kU16:
      return 2;
    case StreamType::kU24:
      return 3;
    default:
      return 4;
  }
}

json to_json(const BlockInfo& block) {
  json out = {{"kind", block.moving      ? "dynamic"
                       : block.nodes > 0 ? "canonical"
                                         : "static"},
              {"bytes", block.bytes},
              {"crc32", block.crc32},
              {"visible", list_of(block.visible)},
              {"count", block.count}};
  if (block.head > 0) {
    out["head"] = block.head;
  } else {
    out["level"] = block.level;
    out["segment"] = list_of(block.segment);
  }
  if (block.window >= 0) out["window"] = block.window;
  if (block.nodes > 0) {
    out["nodes"] = block.nodes;
    out["knots"] = block.knots;
  }
  if (block.file.empty())
    out["offset"] = block.offset;
  else
    out["file"] = block.file;
  for (const StreamInfo& stream : block.streams) out["streams"].push_back(to_json(stream));
  return out;
}

BlockInfo block_from(const json& object, uint64_t version, size_t windows, const fs::path& path) {
  const CheckedObject reading(object, path, "a block");
  BlockInfo block;
  const std::string kind = reading.text("kind");
  const bool is_canonical = kind == "canonical" && version == kTessera4dNodesVersion;
  if (kind != "static" && kind != "dynamic" && !is_canonical)
    reading.fail(fmt::format("is of kind '{}', expected static or dynamic", kind));
  block.moving = kind == "dynamic";
  if (is_canonical) {
    block.nodes = int64_t(reading.whole("nodes", kMaxNodes));
    block.knots = int(reading.whole("knots", kMaxKnots));
    if (block.nodes == 0 || block.knots < kSplineOrder)
      reading.fail(
          fmt::format("has {} motion nodes with {} control points", block.nodes, block.knots));
  }
  if (reading.has("file"))
    block.file = plain_name(reading);
  else
    block.offset = reading.whole("offset", kMost);
  block.bytes = reading.whole("bytes", kMost);
  block.crc32 = uint32_t(reading.whole("crc32", UINT32_MAX));
  block.visible = reading.interval("visible");
  block.count = int64_t(reading.whole("count", uint64_t(kMostGaussians)));
  if (version == kTessera4dWindowsVersion)
    read_window(reading, windows, block);
  else
    block.streams = streams_from(reading.list("streams"), block, path);
  return block;
}

std::string head_of(const BlockInfo& block) {
  json streams = json::array();
  for (const StreamInfo& stream : block.streams) streams.push_back(to_json(stream));
  return json({{"streams", streams}}).dump();
}

std::vector<StreamInfo> streams_of_head(std::string_view bytes, const BlockInfo& block,
                                        const fs::path& path) {
  const json head = parse_json(std::string(bytes.substr(0, block.head)), path);
  BlockInfo behind = block;
  behind.bytes -= block.head;
  return streams_from(CheckedObject(head, path, "the head of a block").list("streams"), behind,
                      path);
}

}  // namespace tessera
