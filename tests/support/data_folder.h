// Finds third-party test data outside the project. Tests are skipped without it.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>

namespace tessera::testing {

/// `name` inside $TESSERA_DATA, or inside `shared/data` beside a folder above this source file.
/// Empty when there is none.
inline std::filesystem::path data_folder(const std::string& name) {
  namespace fs = std::filesystem;
  if (const char* root = std::getenv("TESSERA_DATA")) {
    const fs::path folder = fs::path(root) / name;
    return fs::exists(folder) ? folder : fs::path();
  }
  const fs::path source = fs::absolute(__FILE__);
  for (fs::path parent = source.parent_path(); parent != parent.root_path();
       parent = parent.parent_path()) {
    const fs::path folder = parent / "shared" / "data" / name;
    if (fs::exists(folder)) return folder;
  }
  return {};
}

}  // namespace tessera::testing
