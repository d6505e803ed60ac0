// What: which of the two is wrong.
// Not: permissions; who reads the folder reports those.
#include "ingest/files/input_folder.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"

namespace tessera {

void require_folder(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return;
  if (std::filesystem::exists(path))
    throw InputError(fmt::format("{}: is a file; pass the folder that holds it", path.string()));
  throw InputError(fmt::format("{}: no such folder; check the path", path.string()));
}

}  // namespace tessera
