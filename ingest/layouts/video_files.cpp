// Goes by the names of the files, and by the first bytes of those whose names say nothing.
#include "ingest/layouts/video_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "ingest/images/image_names.h"
#include "ingest/images/listing.h"
#include "ingest/prepared/transforms_json.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct Chapter {
  std::string recording;  // "gx0012"
  int number = 0;         // 1 is the first
};

/// Of GoPro's names: GX020012 is chapter 2 of recording 0012, and so are GH and GL; GOPR0012 is
/// followed by GP010012.
std::optional<Chapter> gopro_chapter(const fs::path& file) {
  const std::string stem = lower_case(file.stem().string());
  if (stem.size() != 8) return std::nullopt;
  const std::string kind = stem.substr(0, 2), digits = stem.substr(2);
  const auto are_digits = [](const std::string& text) {
    return text.find_first_not_of("0123456789") == std::string::npos;
  };
  if (kind == "go" && digits.starts_with("pr") && are_digits(digits.substr(2)))
    return Chapter{"gp" + digits.substr(2), 0};
  if ((kind == "gx" || kind == "gh" || kind == "gl" || kind == "gp") && are_digits(digits))
    return Chapter{kind + digits.substr(2), std::stoi(digits.substr(0, 2))};
  return std::nullopt;
}

/// Whether the stems, sorted, are one name with consecutive numbers, which is no camera's.
bool are_numbered_chapters(const std::vector<fs::path>& files) {
  std::optional<NumberedName> before;
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    const auto name = parse_stem(stem);
    if (!name || is_camera_name(stem)) return false;
    if (before && (name->camera != before->camera || name->number != before->number + 1))
      return false;
    before = name;
  }
  return true;
}

void require_consecutive(const std::map<int, fs::path>& chapters) {
  for (auto chapter = std::next(chapters.begin()); chapter != chapters.end(); ++chapter)
    if (const auto& [number, file] = *std::prev(chapter); chapter->first != number + 1)
      throw InputError(fmt::format(
          "{}: the chapter after {} is missing, {} follows; copy it from the camera, or take the "
          "later chapters out",
          file.parent_path().string(), file.filename().string(),
          chapter->second.filename().string()));
}

/// The files as one camera; nothing where they are several.
std::optional<std::vector<fs::path>> one_recording(const fs::path& folder) {
  std::vector<fs::path> files = videos_in(folder);
  if (files.empty()) return std::nullopt;
  if (files.size() == 1 || are_numbered_chapters(files)) return files;
  std::vector<VideoCamera> cameras = video_cameras_in(folder);
  if (cameras.size() != 1) return std::nullopt;
  return std::move(cameras.front().files);
}

bool has_poses(const fs::path& folder) {
  return has_transforms(folder) || fs::exists(folder / "sparse") ||
         fs::exists(folder / "poses_bounds.npy");
}

}  // namespace

std::vector<fs::path> videos_in(const fs::path& folder) {
  std::vector<fs::path> videos;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool is_hidden = entry.path().filename().string().front() == '.';
    std::error_code unreachable;  // a link to itself is opened later, and named then
    if (!is_hidden && !entry.is_directory(unreachable) &&
        kind_of_file(entry.path()) == FileKind::kVideo)
      videos.push_back(entry.path());
  }
  std::sort(videos.begin(), videos.end());
  return videos;
}

std::vector<VideoCamera> video_cameras_in(const fs::path& folder) {
  std::map<std::string, std::map<int, fs::path>> recordings;
  std::vector<VideoCamera> cameras;
  for (const fs::path& file : videos_in(folder)) {
    const auto chapter = gopro_chapter(file);
    if (!chapter || !recordings[chapter->recording].emplace(chapter->number, file).second)
      cameras.push_back({file.stem().string(), {file}});
  }
  for (const auto& [recording, chapters] : recordings) {
    require_consecutive(chapters);
    VideoCamera& camera = cameras.emplace_back();
    for (const auto& [number, file] : chapters) camera.files.push_back(file);
    camera.name = camera.files.front().stem().string();
  }
  std::stable_sort(cameras.begin(), cameras.end(),
                   [](const VideoCamera& a, const VideoCamera& b) { return a.name < b.name; });
  return cameras;
}

VideoFolders find_video_folders(const fs::path& capture) {
  VideoFolders found;
  bool named = true, has_chapters = false;
  std::set<std::string> stems;
  std::vector<std::string> names;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(capture, unreachable)) {
    std::error_code unresolved;
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory(unresolved) || name.starts_with('.')) continue;
    if (fs::directory_iterator(entry.path(), unresolved); unresolved) continue;
    if (videos_in(entry.path()).empty()) continue;
    auto files = one_recording(entry.path());
    if (!files || has_poses(entry.path())) return {};
    named = named && is_camera_name(name);
    has_chapters = has_chapters || files->size() > 1;
    stems.insert(files->front().stem().string());
    names.push_back(name);
    found.cameras.push_back({name, std::move(*files)});
  }
  if (found.cameras.size() < 2) return {};
  std::sort(found.cameras.begin(), found.cameras.end(),
            [](const VideoCamera& a, const VideoCamera& b) { return a.name < b.name; });
  std::sort(names.begin(), names.end());
  found.seen = fmt::format("{} folders of {} ({})", names.size(),
                           has_chapters ? "chapters of one video each" : "a video each",
                           listed_names(names));
  if (named)
    found.evidence = RigEvidence::kRig;
  else if (has_chapters || stems.size() == 1)
    found.evidence = RigEvidence::kUnclear;
  return found;
}

std::vector<VideoCamera> video_cameras(const fs::path& capture) {
  std::vector<VideoCamera> cameras = video_cameras_in(capture);
  return cameras.empty() ? find_video_folders(capture).cameras : cameras;
}

}  // namespace tessera
