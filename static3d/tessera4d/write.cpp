// Writes a model of one time as a Tessera 4D file, in memory or as a folder.
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "static3d/tessera4d/blocks_writer.h"
#include "static3d/tessera4d/tessera4d.h"

namespace tessera {

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

}  // namespace tessera
