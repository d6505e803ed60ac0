// Writes a model of one time as a Tessera 4D file; folders and single files of all versions.
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/blocks_writer.h"
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

int64_t Tessera4dFile::bytes() const {
  int64_t sum = int64_t(manifest.size());
  for (const auto& [name, block] : blocks) sum += int64_t(block.size());
  return sum;
}

Tessera4dFile encode_tessera4d(const GaussianModel& model, const Tessera4dOptions& options) {
  Tessera4dFile file;
  BlocksWriter writer(model, options, scene_box(model),
                      [&](const std::string& name, std::string bytes) {
                        file.blocks.emplace_back(name, std::move(bytes));
                      });
  writer.add_static(model.static_set, model.nodes);
  writer.add_dynamic(model);
  file.manifest = to_json(writer.manifest(), model).dump(1) + "\n";
  static_cast<Tessera4dCounts&>(file) = writer.counts();
  return file;
}

void write_tessera4d_folder(const std::filesystem::path& folder, const Tessera4dFile& file) {
  make_folder(folder);
  for (const auto& [name, bytes] : file.blocks) write_text_file(folder / name, bytes);
  write_text_file(folder / kTessera4dManifest, file.manifest);
}

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
