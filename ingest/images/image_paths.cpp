// Tries a stated path with the extensions of images. Sub-folders are not searched.
#include "ingest/images/image_paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "ingest/images/names.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

constexpr std::array<std::string_view, 8> kExtensions{".png",  ".jpg", ".jpeg", ".webp",
                                                      ".tiff", ".tif", ".bmp",  ".exr"};

std::filesystem::path with_slashes(std::string file_path) {
  std::replace(file_path.begin(), file_path.end(), '\\', '/');
  return file_path;
}

}  // namespace

bool is_image_name(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

bool is_file(const std::filesystem::path& path) {
  std::error_code unreachable;
  return std::filesystem::is_regular_file(path, unreachable);
}

std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> images;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (is_file(entry.path()) && is_image_name(entry.path()) &&
        !entry.path().filename().string().starts_with('.'))
      images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  return images;
}

std::filesystem::path with_image_extension(const std::filesystem::path& path) {
  for (const std::string_view extension : kExtensions) {
    std::filesystem::path whole = path;
    if (is_file(whole += extension)) return whole;
  }
  return {};
}

std::filesystem::path require_image(const std::filesystem::path& folder,
                                    const std::string& file_path, const std::string& where) {
  const std::filesystem::path stated = folder / with_slashes(file_path);
  if (is_file(stated)) return stated;
  if (auto found = with_image_extension(stated); !found.empty()) return found;
  throw InputError(fmt::format("{}: no such image as {}{}; restore it or remove the frame", where,
                               stated.string(), is_image_name(stated) ? "" : "(.png)"));
}

std::string name_of_image(const std::string& file_path) {
  const std::filesystem::path stated = with_slashes(file_path);
  std::filesystem::path name;
  for (const std::filesystem::path& part : stated.relative_path().lexically_normal())
    if (part != "." && part != ".." && !part.empty()) name /= part;
  if (is_image_name(name)) name.replace_extension();
  return plain_name(name.generic_string());
}

}  // namespace tessera
