// The root of the source tree, and which of its files are sources, pages, or part of the player.
#pragma once
#include <filesystem>
#include <string>

namespace tessera {

inline const std::filesystem::path kSourceRoot = TESSERA_SOURCE_DIR;

inline bool is_source(const std::filesystem::path& path) {
  const std::string kind = path.extension();
  return kind == ".h" || kind == ".cpp" || kind == ".cu" || kind == ".cuh" || kind == ".inc";
}

/// A source of the tests and scripts that is not C++.
inline bool is_script(const std::filesystem::path& path) {
  const std::string kind = path.extension();
  return kind == ".mjs" || kind == ".py" || kind == ".sh" || kind == ".cmake";
}

/// A page of the documentation.
inline bool is_page(const std::filesystem::path& path) {
  return path.extension() == ".md";
}

/// A source of the web player, of those that are not C++.
inline bool is_player_source(const std::filesystem::path& path) {
  return path.extension() == ".ts" || path.extension() == ".html";
}

}  // namespace tessera
