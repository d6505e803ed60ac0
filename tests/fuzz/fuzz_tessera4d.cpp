// Fuzz target: the reader of the Tessera 4D file (one file) on arbitrary bytes. Manifest and
// streams are mutated inside the container, so that lengths and checksums stay valid. See
// scripts/fuzz.sh.
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "ingest/files/gzip.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tests/fuzz/hostile_file.h"

namespace {

using nlohmann::json;
using tessera::gunzip;
using tessera::gzip;

constexpr size_t kHead = 12;  // magic, version, length of the manifest

struct SingleFile {
  json manifest;
  std::string blocks;
};

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

void mutate(std::string& bytes) {
  const size_t before = bytes.size();
  bytes.resize(before + 64);
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), before, bytes.size()));
}

bool split(const std::string& file, SingleFile& parts) {
  if (file.size() < kHead) return false;
  uint32_t length = 0;
  std::memcpy(&length, file.data() + 8, sizeof length);
  if (length > file.size() - kHead) return false;
  parts.manifest = json::parse(file.substr(kHead, length), nullptr, false);
  parts.blocks = file.substr(kHead + length);
  return parts.manifest.is_object() && parts.manifest.contains("blocks") &&
         parts.manifest["blocks"].is_array() && !parts.manifest["blocks"].empty();
}

/// The bytes of a block or a stream in `all` by its stated range; false where the range is invalid.
bool range_of(const json& info, const std::string& all, size_t& offset, size_t& bytes) {
  if (!info.is_object() || !info.contains("offset") || !info.contains("bytes")) return false;
  if (!info["offset"].is_number_unsigned() || !info["bytes"].is_number_unsigned()) return false;
  offset = info["offset"];
  bytes = info["bytes"];
  return offset <= all.size() && bytes <= all.size() - offset;
}

/// Another value for a number, a text or a flag of the manifest.
void change_value(json& manifest, unsigned seed) {
  json flat = manifest.flatten();
  auto leaf = flat.begin();
  std::advance(leaf, seed % flat.size());
  const json values[] = {0,
                         1,
                         -1,
                         255,
                         65536,
                         1u << 28,
                         uint64_t(1) << 40,
                         0.5,
                         1e300,
                         nullptr,
                         "f32",
                         "u24",
                         "smallest3",
                         "none",
                         true,
                         json::array(),
                         json::object(),
                         UINT64_MAX,
                         3,
                         4};
  *leaf = values[seed / 7919 % std::size(values)];
  try {
    manifest = flat.unflatten();
  } catch (const json::exception&) {
    return;  // keys that cannot be put together again: as it was
  }
}

/// Unpacks a stream, changes it and puts it at the end of the blocks.
void change_stream(SingleFile& file, unsigned seed) {
  json& blocks = file.manifest["blocks"];
  json& block = blocks[seed % blocks.size()];
  size_t position = 0, length = 0, stream_at = 0, stream_length = 0;
  if (!range_of(block, file.blocks, position, length)) return;
  std::string bytes = file.blocks.substr(position, length);
  if (!block.contains("streams") || !block["streams"].is_array() || block["streams"].empty())
    return;
  json& stream = block["streams"][seed / 31 % block["streams"].size()];
  if (!range_of(stream, bytes, stream_at, stream_length)) return;
  std::string plain = gunzip(bytes.substr(stream_at, stream_length), 1 << 20, "seed");
  mutate(plain);
  const std::string packed = gzip(plain);
  stream["offset"] = bytes.size();
  stream["bytes"] = packed.size();
  bytes += packed;
  block["offset"] = file.blocks.size();
  block["bytes"] = bytes.size();
  file.blocks += bytes;
}

/// Changes a value in the head of a block of a file of windows, and puts the block at the end.
void change_head(SingleFile& file, unsigned seed) {
  json& block = file.manifest["blocks"][seed % file.manifest["blocks"].size()];
  size_t position = 0, length = 0;
  if (!range_of(block, file.blocks, position, length) || !block.contains("head")) return;
  if (!block["head"].is_number_unsigned() || block["head"] > length) return;
  const size_t size = block["head"];
  json head = json::parse(file.blocks.substr(position, size), nullptr, false);
  if (!head.is_object() || head.empty()) return;
  change_value(head, seed / 31);
  const std::string text = head.dump(-1, ' ', false, json::error_handler_t::replace),
                    bytes = text + file.blocks.substr(position + size, length - size);
  block["head"] = text.size();
  block["offset"] = file.blocks.size();
  block["bytes"] = bytes.size();
  file.blocks += bytes;
}

std::string join(SingleFile& file) {
  for (json& block : file.manifest["blocks"]) {
    size_t position = 0, length = 0;
    if (range_of(block, file.blocks, position, length))
      block["crc32"] =
          crc32(0, reinterpret_cast<const Bytef*>(file.blocks.data() + position), uInt(length));
  }
  const std::string text = file.manifest.dump(-1, ' ', false, json::error_handler_t::replace);
  std::string bytes = "TES4";
  for (const uint32_t number : {1u, uint32_t(text.size())})
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  return bytes + text + file.blocks;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".tes4", [](const auto& path) {
    tessera::Tessera4dParts parts = tessera::open_tessera4d(path);
    parts.load(0);
    if (const size_t windows = parts.windows().size(); windows > 1) parts.load(int(windows) - 1);
  });
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  SingleFile file;
  if (seed % 4 == 0 || !split(std::string(reinterpret_cast<const char*>(data), size), file))
    return LLVMFuzzerMutate(data, size, most);
  try {
    if (seed % 4 == 1)
      file.manifest.contains("windows") ? change_head(file, seed / 4)
                                        : change_stream(file, seed / 4);
    if (seed % 4 >= 2) change_value(file.manifest, seed / 4);
    if (!file.manifest.is_object() || !file.manifest["blocks"].is_array())
      return LLVMFuzzerMutate(data, size, most);
    const std::string bytes = join(file);
    if (bytes.size() > most) return LLVMFuzzerMutate(data, size, most);
    std::copy(bytes.begin(), bytes.end(), data);
    return bytes.size();
  } catch (const tessera::InputError&) {  // a stream that was broken before
    return LLVMFuzzerMutate(data, size, most);
  }
}
