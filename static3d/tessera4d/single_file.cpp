// The single file of the format: one head, then the blocks one behind the other.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/container.h"
#include "static3d/tessera4d/tessera4d.h"

namespace tessera {
namespace {

/// What is in front of the blocks: of the manifest of a folder.
std::string head_of_single(nlohmann::json manifest) {
  uint64_t offset = 0;
  for (nlohmann::json& block : manifest["blocks"]) {
    block.erase("file");
    block["offset"] = offset;
    offset += block["bytes"].get<uint64_t>();
  }
  const std::string text = manifest.dump();
  std::string head(kTessera4dMagic);
  append(head, manifest["version"].get<uint32_t>());
  append(head, uint32_t(text.size()));
  return head + text;
}

}  // namespace

std::string single_tessera4d(const Tessera4dFile& file) {
  std::string out = head_of_single(nlohmann::json::parse(file.manifest));
  for (const auto& [name, bytes] : file.blocks) out += bytes;
  return out;
}

void single_from_folder(const std::filesystem::path& folder, const std::filesystem::path& path) {
  const Tessera4dContainer container(folder);
  AtomicFile out(path);
  out.write(head_of_single(container.json()));
  for (const BlockInfo& block : container.manifest().blocks) {
    const std::string bytes = container.block(block);
    check_block(bytes, block, container.file_of(block));
    out.write(bytes);
  }
  out.commit();
}

}  // namespace tessera
