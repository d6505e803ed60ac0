// Goes by a listing, from which the files that were taken are gone.
#include "ingest/layouts/unread_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "ingest/images/image_names.h"
#include "ingest/images/listing.h"
#include "ingest/test_views.h"
#include "kernels/base/counted.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> other_media_lines(const fs::path& capture,
                                           const std::vector<ListedFile>& files) {
  std::map<std::string, int64_t> counts;
  for (const ListedFile& file : files)
    if (file.kind == FileKind::kOtherMedia) ++counts[lower_case(file.path.extension().string())];
  std::vector<std::string> lines;
  for (const auto& [extension, count] : counts)
    lines.push_back(fmt::format(
        "{}: {} {} {} not read; to use them, convert them to JPEG or PNG, or videos to MP4",
        capture.string(), count, extension.empty() ? "image without extension" : extension,
        count == 1 ? "file is" : "files are"));
  return lines;
}

std::string below(const fs::path& path, const fs::path& capture) {
  return path.lexically_relative(capture).generic_string();
}

/// Tables that speak of cameras, by folder and extension; those of a rig beside its clips are named
/// with its calibration.
std::vector<std::string> table_lines(const fs::path& capture, const std::vector<ListedFile>& files,
                                     bool of_clips) {
  std::map<std::string, std::vector<fs::path>> groups;
  for (const ListedFile& file : files)
    if (file.kind == FileKind::kTable && !(of_clips && file.path.parent_path() == capture) &&
        speaks_of_cameras(file.path))
      groups[(file.path.parent_path() / file.path.extension()).string()].push_back(file.path);
  std::vector<std::string> lines;
  for (const auto& [group, tables] : groups)
    lines.push_back(
        fmt::format("{}: not read, though {} to state cameras: {}{}", capture.string(),
                    tables.size() == 1 ? "it seems" : "they seem", below(tables.front(), capture),
                    tables.size() == 1 ? "" : fmt::format(" and {} like it", tables.size() - 1)));
  return lines;
}

bool lies_below(const fs::path& file, const fs::path& folder) {
  const fs::path inside = file.lexically_relative(folder);
  return !inside.empty() && *inside.begin() != "..";
}

/// How many images each folder holds, of those without a file that was taken.
std::map<std::string, int64_t> folders_of_images(const fs::path& capture,
                                                 const std::vector<ListedFile>& files,
                                                 const std::set<fs::path>& taken) {
  std::set<fs::path> of_taken;
  for (const fs::path& file : taken) of_taken.insert(file.parent_path());
  std::map<std::string, int64_t> counts;
  for (const ListedFile& file : files)
    if (file.kind == FileKind::kImage &&
        !of_taken.contains(file.path.parent_path().lexically_normal()))
      ++counts[below(file.path.parent_path(), capture)];
  return counts;
}

}  // namespace

std::set<fs::path> taken_files(const Capture& capture) {
  std::set<fs::path> taken;
  const auto take = [&](const fs::path& file) {
    if (!file.empty()) taken.insert(file.lexically_normal());
  };
  for (const CaptureFrame& frame : capture.frames) {
    take(frame.image);
    take(frame.mask);
  }
  for (const RigClip& clip : capture.clips) {
    take(clip.video);
    for (const fs::path& chapter : clip.chapters) take(chapter);
    for (const NumberedImage& image : clip.images) take(image.file);
  }
  if (!capture.photos.empty())  // what a model does not name is named with it
    for (const ListedFile& file : list_files(capture.photos))
      if (file.kind == FileKind::kImage) take(file.path);
  for (const auto& [name, file] : capture.files) take(file);
  return taken;
}

UnreadFiles unread_files(const fs::path& capture, const std::set<fs::path>& taken,
                         const fs::path& masks, bool of_clips) {
  std::vector<ListedFile> files = list_files(capture);
  std::erase_if(files, [&](const ListedFile& file) {
    return taken.contains(file.path.lexically_normal()) ||
           lies_below(file.path, capture / "masks") ||
           (!masks.empty() && lies_below(file.path, masks));
  });
  UnreadFiles unread;
  unread.warnings = other_media_lines(capture, files);
  std::vector<std::string> videos, cameras, folders;
  for (const ListedFile& file : files)
    if (file.kind == FileKind::kVideo) videos.push_back(below(file.path, capture));
  if (!videos.empty())
    unread.warnings.push_back(fmt::format(
        "{}: not read, though they are videos: {}{}", capture.string(), listed_names(videos),
        of_clips ? "; the videos of a rig lie side by side, or each in a folder of its own" : ""));
  for (std::string& line : table_lines(capture, files, of_clips))
    unread.notes.push_back(std::move(line));
  for (const auto& [folder, count] : folders_of_images(capture, files, taken)) {
    const bool is_camera = of_clips && is_camera_name(fs::path(folder).filename().string());
    (is_camera ? cameras : folders)
        .push_back(fmt::format("{} ({})", folder, counted(int64_t(count), "image")));
  }
  if (!cameras.empty())
    unread.warnings.push_back(fmt::format(
        "{}: not read, though they are called like cameras and hold images: {}; the images of a "
        "camera are one series, numbered as those of the others",
        capture.string(), listed_names(cameras)));
  if (!folders.empty())
    unread.notes.push_back(
        fmt::format("{}: not read: {}", capture.string(), listed_names(folders)));
  return unread;
}

std::string unused_masks(const fs::path& capture) {
  const fs::path masks = capture / "masks";
  for (const ListedFile& file : list_files(masks))
    if (file.kind == FileKind::kImage)
      return fmt::format(
          "{}: holds images and is not read; to ignore what is black there, pass --masks {}",
          masks.string(), masks.string());
  return "";
}

std::string with_unread_files(std::string error, const fs::path& capture) {
  const std::vector<ListedFile> files = list_files(capture);
  for (const auto& lines : {other_media_lines(capture, files), table_lines(capture, files, true)})
    for (const std::string& line : lines) error += "; " + line;
  return error;
}

}  // namespace tessera
