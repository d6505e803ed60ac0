// What: which of the two is wrong.
// Not: permissions; who reads the folder reports those.
#include "ingest/files/input_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "kernels/base/errors.h"

namespace tessera {

namespace {

/// What to do with a file where a folder is expected, by the kind that its name says.
std::string advice_for_file(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c + ('a' - 'A')) : c;
  const auto is_one_of = [&](std::initializer_list<const char*> endings) {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  };
  if (is_one_of({".mp4", ".mkv", ".mov", ".avi", ".webm"}))
    return "is a video; put it into a folder of its own, with the other cameras' videos, and give "
           "that folder: tessera run FOLDER -o OUT";
  if (is_one_of({".ply", ".spz", ".splat", ".ckpt", ".t4d"}))
    return "is a model or a point cloud, not a capture; tessera info says what is in it";
  return "is a file; pass the folder that holds it";
}

}  // namespace

void require_folder(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return;
  if (std::filesystem::exists(path))
    throw InputError(fmt::format("{}: {}", path.string(), advice_for_file(path)));
  throw InputError(fmt::format("{}: no such folder; check the path", path.string()));
}

}  // namespace tessera
