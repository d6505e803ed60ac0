// Goes by the names of the files; none is opened.
#include "ingest/layouts/unread_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "ingest/images/image_names.h"
#include "ingest/images/image_paths.h"
#include "ingest/layouts/video_files.h"
#include "ingest/test_views.h"
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

/// Down to so many levels, by name; hidden ones are left out.
std::vector<fs::path> folders_below(const fs::path& folder, int levels) {
  std::vector<fs::path> found;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (entry.path().filename().string().starts_with('.') || !entry.is_directory(unresolved))
      continue;
    found.push_back(entry.path());
    if (levels == 1) continue;
    const std::vector<fs::path> inner = folders_below(entry.path(), levels - 1);
    found.insert(found.end(), inner.begin(), inner.end());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::vector<std::string> unread_files(const fs::path& capture, bool has_masks) {
  constexpr int kLevels = 2;
  std::vector<std::string> lines;
  std::map<std::string, int64_t> counts;
  std::vector<fs::path> folders = folders_below(capture, kLevels);
  folders.push_back(capture);
  for (const fs::path& folder : folders) {
    std::error_code unreachable;
    for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
      std::error_code unresolved;
      const fs::path& file = entry.path();
      const bool is_file = !entry.is_directory(unresolved);
      const std::string extension = is_file ? unread_extension(file) : "";
      if (!extension.empty() && !file.filename().string().starts_with('.')) ++counts[extension];
    }
  }
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

std::vector<std::string> unread_clips(const fs::path& capture, const std::vector<RigClip>& clips) {
  std::vector<std::string> lines, unread;
  std::set<fs::path> read;
  std::set<std::string> names;
  for (const RigClip& clip : clips) {
    read.insert(clip.video);
    read.insert(clip.chapters.begin(), clip.chapters.end());
    names.insert(clip.name);
  }
  const bool of_videos = clips.empty() || clips.front().images.empty();
  for (const fs::path& folder : of_videos ? folders_below(capture, 2) : std::vector<fs::path>{})
    for (const fs::path& video : videos_in(folder))
      if (!read.contains(video))
        unread.push_back(video.lexically_relative(capture).generic_string());
  if (!unread.empty())
    lines.push_back(
        fmt::format("{}: not read, though they are videos: {}; the videos of a rig lie side by "
                    "side, or each in a folder of its own",
                    capture.string(), listed_names(unread)));
  unread.clear();
  for (const char* place : {"", "images", "ims", "frames", "rgb"})
    for (const fs::path& folder : folders_below(capture / place, 1)) {
      const std::string name = folder.filename().string();
      if (is_camera_name(name) && !names.contains(name) && holds_images(folder))
        unread.push_back(folder.lexically_relative(capture).generic_string());
    }
  if (!unread.empty())
    lines.push_back(fmt::format(
        "{}: not read, though they are called like cameras and hold images: {}; the images of a "
        "camera are one series, numbered as those of the others",
        capture.string(), listed_names(unread)));
  return lines;
}

std::string with_unread_files(std::string error, const fs::path& capture) {
  for (const std::string& line : unread_files(capture, true)) error += "; " + line;
  return error;
}

}  // namespace tessera
