// What: where the source tree is, and which of its files are sources.
// Not: what is in them.
#pragma once
#include <filesystem>
#include <string>

namespace tessera {

inline const std::filesystem::path kSourceRoot = TESSERA_SOURCE_DIR;

inline bool is_source(const std::filesystem::path& path) {
  const std::string kind = path.extension();
  return kind == ".h" || kind == ".cpp" || kind == ".cu" || kind == ".cuh";
}

}  // namespace tessera
