// Depths are told by the header of an image, cameras and timesteps by the names that folders share.
#include "ingest/layouts/camera_folders.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <string_view>

#include "ingest/images/image_names.h"
#include "ingest/images/image_paths.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

bool holds_images(const fs::path& folder) {
  std::error_code unreachable;
  if (fs::directory_iterator(folder, unreachable); unreachable) return false;
  return !images_in(folder).empty();
}

/// Grey PNG of 16 bits (bytes 24 and 25 of its header), or EXR.
bool is_depth(const fs::path& image) {
  if (lower_case(image.extension().string()) == ".exr") return true;
  std::array<char, 26> head{};
  std::ifstream(image, std::ios::binary).read(head.data(), head.size());
  return std::string_view(head.data(), 4) == "\x89PNG" && head[24] == 16 && head[25] == 0;
}

}  // namespace

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (entry.is_directory(unresolved) && !entry.path().filename().string().starts_with('.'))
      folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

fs::path images_of_camera(const fs::path& folder) {
  if (holds_images(folder)) return folder;
  if (holds_images(folder / "images")) return folder / "images";
  fs::path colour;
  for (const fs::path& inner : folders_in(folder)) {
    if (!holds_images(inner) || is_depth(images_in(inner).front())) continue;
    if (!colour.empty()) return {};
    colour = inner;
  }
  return colour;
}

std::vector<fs::path> parents_of_cameras(const fs::path& capture) {
  std::vector<fs::path> parents{capture};
  if (fs::is_directory(capture / "images")) parents.push_back(capture / "images");
  for (const fs::path& folder : folders_in(capture))
    if (folder.filename() != "images" && !holds_images(folder)) parents.push_back(folder);
  return parents;
}

std::vector<ImageSequence> sequences_of_timesteps(const fs::path& capture) {
  std::map<std::string, std::map<int64_t, std::vector<fs::path>>> series;  // by name and number
  for (const fs::path& folder : folders_in(capture))
    if (const auto name = parse_stem(folder.filename().string()))
      if (const fs::path images = images_of_camera(folder); !images.empty())
        series[name->camera][name->number] = images_in(images);
  if (series.size() != 1 || series.begin()->second.size() < 2) return {};
  const auto& timesteps = series.begin()->second;
  std::map<std::string, ImageSequence> cameras;
  for (const auto& [number, images] : timesteps)
    for (const fs::path& image : images) {
      ImageSequence& camera = cameras[image.stem().string()];
      camera.images.push_back({number, image});
    }
  std::vector<ImageSequence> complete;
  for (auto& [name, camera] : cameras) {
    const bool is_number = name.find_first_not_of("0123456789") == std::string::npos;
    if (is_number || 10 * camera.images.size() < 9 * timesteps.size()) continue;
    camera.camera = name;
    camera.path = capture / name;
    complete.push_back(std::move(camera));
  }
  return 10 * complete.size() >= 9 * cameras.size() ? complete : std::vector<ImageSequence>{};
}

}  // namespace tessera
