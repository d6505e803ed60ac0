// What: a capture's layout by the files that are there.
// Not: a look inside them; a broken file is its reader's to report.
#include "ingest/capture_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "ingest/colmap_model.h"
#include "ingest/image_paths.h"
#include "ingest/transforms_json.h"
#include "kernels/base/errors.h"

namespace tessera {

std::vector<std::filesystem::path> videos_in(const std::filesystem::path& folder) {
  constexpr std::array<const char*, 5> kExtensions{".mp4", ".mkv", ".mov", ".avi", ".webm"};
  std::vector<std::filesystem::path> videos;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    const bool is_video =
        std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
    const bool is_hidden = entry.path().filename().string().front() == '.';
    std::error_code unreachable;  // a link to itself is opened later, and named then
    if (is_video && !is_hidden && !entry.is_directory(unreachable)) videos.push_back(entry.path());
  }
  std::sort(videos.begin(), videos.end());
  return videos;
}

const char* layout_name(CaptureLayout layout) {
  switch (layout) {
    case CaptureLayout::kTransforms:
      return "transforms";
    case CaptureLayout::kN3dv:
      return "n3dv";
    case CaptureLayout::kColmap:
      return "colmap";
    case CaptureLayout::kLlff:
      return "llff";
    case CaptureLayout::kVideos:
      return "videos";
    case CaptureLayout::kPhotos:
      return "photos";
  }
  return "";
}

bool has_pictures(const std::filesystem::path& capture) {
  if (!pictures_in(capture).empty()) return true;
  for (const auto& entry : std::filesystem::directory_iterator(capture)) {
    std::error_code unreachable;
    if (entry.path().filename().string().starts_with("images") && entry.is_directory(unreachable) &&
        !pictures_in(entry.path()).empty())
      return true;
  }
  return false;
}

CaptureLayout detect_layout(const std::filesystem::path& capture) {
  if (!std::filesystem::is_directory(capture))
    throw InputError(fmt::format("{}: no such folder; check the path", capture.string()));
  if (has_transforms(capture)) return CaptureLayout::kTransforms;
  const bool has_videos = !videos_in(capture).empty();
  if (has_videos && std::filesystem::exists(capture / "poses_bounds.npy"))
    return CaptureLayout::kN3dv;
  if (!find_colmap_model(capture).empty()) return CaptureLayout::kColmap;
  const bool has_photos = has_pictures(capture);
  if (has_photos && std::filesystem::exists(capture / "poses_bounds.npy"))
    return CaptureLayout::kLlff;
  if (has_videos) return CaptureLayout::kVideos;
  if (has_photos && std::filesystem::exists(capture / "sparse"))
    throw InputError(fmt::format(
        "{}: holds no COLMAP model (cameras.bin or cameras.txt, in it or in sparse/0); restore it, "
        "or remove the folder to have poses estimated",
        (capture / "sparse").string()));
  if (has_photos) return CaptureLayout::kPhotos;
  throw InputError(fmt::format(
      "{}: no transforms.json, no transforms_train.json, no COLMAP model (sparse/0 or sparse with "
      "cameras.bin or cameras.txt), no videos (*.mp4, *.mkv, *.mov, *.avi, *.webm) and no pictures "
      "(in images or beside each other) in it; name the folder that holds the capture",
      capture.string()));
}

CaptureLayout layout_of(const std::filesystem::path& capture, const IngestOptions& options) {
  const std::string& poses = options.poses.source;
  if (options.layout) return *options.layout;
  if (poses.empty()) return detect_layout(capture);
  const CaptureLayout detected = detect_layout(capture);
  const bool has_videos = !videos_in(capture).empty();
  if (poses == "llff") return CaptureLayout::kLlff;
  if (poses == "n3dv") {
    if (detected == CaptureLayout::kN3dv) return detected;
    throw InputError(fmt::format(
        "{}: has no videos with a poses_bounds.npy, which --poses n3dv reads; add the file or "
        "leave --poses out",
        capture.string()));
  }
  if (poses == "colmap") {
    if (!find_colmap_model(capture).empty()) return CaptureLayout::kColmap;
    return has_videos ? CaptureLayout::kVideos : CaptureLayout::kPhotos;
  }
  if (!std::filesystem::is_regular_file(poses))
    throw InputError(fmt::format(
        "--poses '{}': no such file; expected n3dv, llff, colmap or a file of cameras", poses));
  if (!has_videos)
    throw InputError(fmt::format("{}: has no videos, and --poses {} is for those; leave it out",
                                 capture.string(), poses));
  return CaptureLayout::kVideos;
}

}  // namespace tessera
