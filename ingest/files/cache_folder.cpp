// By the XDG Base Directory Specification, version 0.8, which has relative paths ignored.
#include "ingest/files/cache_folder.h"

#include <cstdlib>

namespace tessera {
namespace {

std::filesystem::path absolute_path_of(const char* variable) {
  const char* const value = std::getenv(variable);
  const std::filesystem::path path = value == nullptr ? "" : value;
  return path.is_absolute() ? path : std::filesystem::path();
}

}  // namespace

std::filesystem::path user_cache_folder() {
  const std::filesystem::path stated = absolute_path_of("XDG_CACHE_HOME");
  if (!stated.empty()) return stated / "tessera";
  const std::filesystem::path home = absolute_path_of("HOME");
  return home.empty() ? home : home / ".cache" / "tessera";
}

}  // namespace tessera
