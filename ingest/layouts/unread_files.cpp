// Goes by the names of the files; none is opened.
#include "ingest/layouts/unread_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "ingest/images/image_paths.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The extension in small letters where it is one of media that nothing here reads, else "".
std::string unread_extension(const fs::path& file) {
  constexpr std::array<std::string_view, 16> kUnread{
      ".heic", ".heif", ".avif", ".jp2", ".dng", ".cr2", ".cr3",  ".nef",
      ".arw",  ".raf",  ".gif",  ".m4v", ".mts", ".mxf", ".insv", ".360"};
  std::string extension = lower_case(file.extension().string());
  const bool is_unread = std::find(kUnread.begin(), kUnread.end(), extension) != kUnread.end();
  return is_unread ? extension : "";
}

void count_unread(const fs::path& folder, int levels, std::map<std::string, int64_t>& counts) {
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (entry.path().filename().string().starts_with('.')) continue;
    if (entry.is_directory(unresolved)) {
      if (levels > 0) count_unread(entry.path(), levels - 1, counts);
      continue;
    }
    if (const std::string extension = unread_extension(entry.path()); !extension.empty())
      ++counts[extension];
  }
}

/// In it or one level below.
bool holds_images(const fs::path& folder, int levels = 1) {
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (entry.path().filename().string().starts_with('.')) continue;
    if (is_image_name(entry.path())) return true;
    if (levels > 0 && entry.is_directory(unresolved) && holds_images(entry.path(), levels - 1))
      return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> unread_files(const fs::path& capture, bool has_masks) {
  constexpr int kLevels = 2;
  std::vector<std::string> lines;
  std::map<std::string, int64_t> counts;
  count_unread(capture, kLevels, counts);
  for (const auto& [extension, count] : counts)
    lines.push_back(fmt::format(
        "{}: {} {} {} not read; to use them, convert them to JPEG or PNG, or videos to MP4",
        capture.string(), count, extension, count == 1 ? "file is" : "files are"));
  if (const fs::path masks = capture / "masks"; !has_masks && holds_images(masks))
    lines.push_back(
        fmt::format("{}: holds images and is not read; to ignore what is black there, "
                    "pass --masks {}",
                    masks.string(), masks.string()));
  return lines;
}

std::string with_unread_files(std::string error, const fs::path& capture) {
  for (const std::string& line : unread_files(capture, true)) error += "; " + line;
  return error;
}

}  // namespace tessera
