// What: reading and clearing a run folder.
// Not: deleting what Tessera did not write.
#include "tools/run_folder.h"

#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {

nlohmann::json RunFolder::read_config() const {
  nlohmann::json json = nlohmann::json::parse(read_text_file(config()), nullptr, false);
  if (!json.is_object())
    throw InputError(
        fmt::format("{}: not valid JSON; train again with --overwrite", config().string()));
  return json;
}

void RunFolder::remove_files() const {
  for (const std::filesystem::path& file : {config(), log(), checkpoint(), model(), metrics()}) {
    std::error_code ignored;  // what cannot be removed fails with its reason when it is written
    std::filesystem::remove(file, ignored);
  }
}

}  // namespace tessera
