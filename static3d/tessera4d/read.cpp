// Reads a Tessera 4D file of one time into one model, and tells such files from others.
#include <fmt/format.h>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "static3d/tessera4d/block_sets.h"
#include "static3d/tessera4d/tessera4d.h"

namespace tessera {

namespace fs = std::filesystem;

bool is_tessera4d(std::string_view head) {
  return head.starts_with(kTessera4dMagic);
}

bool is_tessera4d_folder(const fs::path& folder) {
  const fs::path path = folder / kTessera4dManifest;
  if (!fs::is_regular_file(path)) return false;
  const nlohmann::json manifest = read_json(path);
  return manifest.is_object() && manifest.value("format", nlohmann::json()) == kTessera4dFormat;
}

Tessera4dInput load_tessera4d(const fs::path& path) {
  const Tessera4dContainer container(path);
  if (const size_t windows = container.manifest().windows.size(); windows > 0)
    throw InputError(
        fmt::format("{}: holds {} windows of a clip, each with a model of its own, and this "
                    "takes one model: name the run of a window",
                    container.path().string(), windows));
  Tessera4dInput input;
  input.model = model_of_blocks(
      container, [](const BlockInfo&) { return true; }, input.warnings);
  input.manifest = container.manifest();
  input.bytes = container.bytes();
  return input;
}

}  // namespace tessera
