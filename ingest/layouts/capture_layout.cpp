// Determines the layout by the names of the files; contents are read where poses decide: rows of
// LLFF, and the names of photos in a COLMAP model.
#include "ingest/layouts/capture_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "ingest/calibration/model_photos.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/files/folders.h"
#include "ingest/images/image_paths.h"
#include "ingest/layouts/name_times.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace fs = std::filesystem;

const std::vector<LayoutRow>& layout_rows() {
  using enum CaptureLayout;
  // clips, photos, estimates poses, stated world
  static const std::vector<LayoutRow> rows{
      {kTransforms, "transforms", false, false, false, true, read_transforms_layout},
      {kN3dv, "n3dv", true, false, true, false, read_clip_layout},
      {kColmap, "colmap", false, true, false, false, read_colmap_layout},
      {kLlff, "llff", false, true, false, false, read_llff_layout},
      {kVideos, "videos", true, false, true, false, read_clip_layout},
      {kSequences, "sequences", true, false, true, false, read_clip_layout},
      {kPhotos, "photos", false, true, true, false, read_photo_layout}};
  return rows;
}

const LayoutRow& row_of(CaptureLayout layout) {
  const std::vector<LayoutRow>& rows = layout_rows();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const LayoutRow& r) { return r.layout == layout; });
  check(row != rows.end(), "a layout without a row");
  return *row;
}

bool has_images(const fs::path& capture) {
  const std::vector<fs::path> folders = photo_folders(capture);
  return std::any_of(folders.begin(), folders.end(),
                     [](const fs::path& folder) { return !images_in(folder).empty(); });
}

namespace {

/// Rows of the capture's poses_bounds.npy; 0 where it cannot be read, which its reader reports.
size_t llff_rows(const fs::path& capture) {
  try {
    return read_llff_poses(capture / "poses_bounds.npy").size();
  } catch (const InputError&) {
    return 0;
  }
}

/// Whether the images are those of a rig. Poses of photos decide where there are some: LLFF has a
/// row an image, a rig a row a camera. Errors: AmbiguousCapture.
bool has_image_rig(const fs::path& capture, std::optional<ImageLayout> image_layout) {
  if (image_layout) return *image_layout == ImageLayout::kRig;
  const ImageSequences found = find_image_sequences(capture);
  if (found.evidence == RigEvidence::kNone) return false;
  const bool posed = fs::exists(capture / "poses_bounds.npy");
  if (posed && !found.in_folders) return llff_rows(capture) == found.cameras.size();
  if (posed || found.evidence == RigEvidence::kRig) return true;
  throw AmbiguousCapture(fmt::format(
      "{}: has {}: one moving scene filmed by {} cameras, or photos of {}; pass --layout rig for "
      "the former, --layout photos for the latter",
      capture.string(), found.seen, found.cameras.size(),
      found.in_folders
          ? fmt::format("{} scenes that stand still, each a capture", found.cameras.size())
          : "one scene that stands still"));
}

/// Whether `capture` has a COLMAP model of photos. Beside videos or image sequences whose frames it
/// does not name it is the calibration of these.
bool has_posed_photos(const fs::path& capture, std::optional<ImageLayout> image_layout) {
  const fs::path model = find_colmap_model(capture);
  if (model.empty()) return false;
  const bool has_videos =
      !videos_in(capture).empty() || find_video_folders(capture).evidence != RigEvidence::kNone;
  const std::vector<fs::path> folders = photo_folders(capture);
  if (folders.empty()) return !has_videos && !has_image_rig(capture, image_layout);
  const bool is_usual = model == capture || *model.lexically_relative(capture).begin() == "sparse";
  if (is_usual && !has_videos && find_image_sequences(capture).evidence == RigEvidence::kNone)
    return true;
  return names_photos(model, folders);
}

/// Whether the sub-folders are cameras with a video each. Errors: AmbiguousCapture.
bool has_video_rig(const fs::path& capture) {
  const VideoFolders found = find_video_folders(capture);
  if (found.evidence != RigEvidence::kUnclear) return found.evidence == RigEvidence::kRig;
  throw AmbiguousCapture(fmt::format(
      "{}: has {}: one scene filmed by {} cameras, or a capture in each folder; pass --layout rig "
      "for the former, name one of the folders for the latter",
      capture.string(), found.seen, found.cameras.size()));
}

/// Whether --layout rig is stated of sub-folders of videos.
bool is_stated_video_rig(const fs::path& capture, std::optional<ImageLayout> image_layout) {
  return image_layout == ImageLayout::kRig && videos_in(capture).empty() &&
         find_image_sequences(capture).cameras.size() < 2 &&
         find_video_folders(capture).cameras.size() > 1;
}

bool is_sequences(std::optional<ImageLayout> image_layout) {
  return image_layout && *image_layout != ImageLayout::kPhotos;
}

/// Whether it is stated where the photos of the capture's COLMAP model lie.
bool states_photos(const fs::path& capture, const IngestOptions& options) {
  if (options.images.empty() || options.image_layout || !fs::is_directory(capture)) return false;
  const PoseSource::Kind poses = options.poses.source.kind;
  if (poses != PoseSource::kFound && poses != PoseSource::kColmap) return false;
  const bool is_n3dv = !videos_in(capture).empty() && fs::exists(capture / "poses_bounds.npy");
  return !is_n3dv && !has_transforms(capture) && !find_colmap_model(capture).empty();
}

/// Whether `folder` is read as a capture, or could be with a statement of how. What cannot be read
/// is none.
bool is_capture(const fs::path& folder, std::optional<ImageLayout> image_layout) {
  try {
    detect_layout(folder, image_layout);
    return true;
  } catch (const AmbiguousCapture&) {
    return true;
  } catch (const InputError&) {
    return false;
  } catch (const fs::filesystem_error&) {
    return false;
  }
}

/// All images as those of one camera that moves.
ImageSequences single_camera(const fs::path& folder) {
  ImageSequences found{{single_sequence(folder)}, RigEvidence::kNone, ""};
  take_times(found);
  return found;
}

}  // namespace

bool has_clips(const fs::path& capture) {
  const std::vector<fs::path> videos = videos_in(capture);
  if (videos.empty()) return false;
  std::set<std::string> photos;
  for (const fs::path& image : images_in(capture)) photos.insert(image.stem().string());
  return !std::all_of(videos.begin(), videos.end(), [&](const fs::path& video) {
    return photos.contains(video.stem().string());
  });
}

CaptureLayout detect_layout(const fs::path& capture, std::optional<ImageLayout> image_layout) {
  require_folder(capture);
  if (is_sequences(image_layout))
    return is_stated_video_rig(capture, image_layout) ? CaptureLayout::kVideos
                                                      : CaptureLayout::kSequences;
  if (has_transforms(capture)) return CaptureLayout::kTransforms;
  const bool has_videos = has_clips(capture);
  if (has_videos && fs::exists(capture / "poses_bounds.npy")) return CaptureLayout::kN3dv;
  if (has_posed_photos(capture, image_layout)) return CaptureLayout::kColmap;
  if (!has_videos && has_image_rig(capture, image_layout)) return CaptureLayout::kSequences;
  const bool has_photos = has_images(capture);
  if (has_photos && fs::exists(capture / "poses_bounds.npy")) return CaptureLayout::kLlff;
  if (has_videos) return CaptureLayout::kVideos;
  if (has_photos && fs::exists(capture / "sparse"))
    throw InputError(fmt::format(
        "{}: holds no COLMAP model (cameras.bin or cameras.txt, in it or in sparse/0); restore it, "
        "or remove the folder to have poses estimated",
        (capture / "sparse").string()));
  if (has_photos) return CaptureLayout::kPhotos;
  if (has_video_rig(capture))
    return fs::exists(capture / "poses_bounds.npy") ? CaptureLayout::kN3dv : CaptureLayout::kVideos;
  throw InputError(fmt::format(
      "{}: no transforms.json, no transforms_train.json, no COLMAP model (sparse/0 or sparse with "
      "cameras.bin or cameras.txt), no videos (*.mp4, *.mkv, *.mov, *.avi, *.webm) and no images "
      "(in images or beside each other) in it; name the folder that holds the capture",
      capture.string()));
}

CaptureLayout layout_of(const fs::path& capture, const IngestOptions& options) {
  using enum PoseSource::Kind;
  const PoseSource& poses = options.poses.source;
  if (options.layout) return *options.layout;
  const bool of_cameras = poses.kind == kN3dv || poses.kind == kCameras;
  std::optional<ImageLayout> image_layout = options.image_layout;
  // poses of cameras are no photos': images that could be either are a rig's
  if (of_cameras && !image_layout && fs::is_directory(capture) && videos_in(capture).empty() &&
      find_image_sequences(capture).evidence != RigEvidence::kNone)
    image_layout = ImageLayout::kRig;
  if (states_photos(capture, options)) return CaptureLayout::kColmap;
  const CaptureLayout detected = detect_layout(capture, image_layout);
  if (options.sample && detected == CaptureLayout::kTransforms &&
      !find_colmap_model(capture).empty())
    return CaptureLayout::kColmap;  // the model has the lenses
  if (poses.kind == kFound || detected == CaptureLayout::kSequences) return detected;
  const bool has_videos = row_of(detected).clips;
  if (poses.kind == kLlff) return CaptureLayout::kLlff;
  if (poses.kind == kN3dv) {
    if (detected == CaptureLayout::kN3dv) return detected;
    throw InputError(fmt::format(
        "{}: has no videos with a poses_bounds.npy, which --poses n3dv reads; add the file or "
        "leave --poses out",
        capture.string()));
  }
  if (poses.kind == kColmap) {
    if (has_posed_photos(capture, image_layout)) return CaptureLayout::kColmap;
    return has_videos ? CaptureLayout::kVideos : CaptureLayout::kPhotos;
  }
  if (!fs::exists(poses.cameras))
    throw InputError(fmt::format(
        "--poses '{}': no such file; expected n3dv, llff, colmap or a file or folder of cameras",
        poses.cameras.string()));
  if (!has_videos)
    throw InputError(fmt::format(
        "{}: has neither videos nor numbered images of several cameras, and --poses {} is for "
        "those; leave it out",
        capture.string(), poses.cameras.string()));
  return CaptureLayout::kVideos;
}

ImageSequences sequences_of(const fs::path& capture, std::optional<ImageLayout> image_layout) {
  if (image_layout == ImageLayout::kMoving) {
    for (const auto& folder : {capture, capture / "images"})
      if (fs::is_directory(folder) && !images_in(folder).empty()) return single_camera(folder);
    throw InputError(fmt::format(
        "{}: has no images, in it or in images, which --layout moving reads", capture.string()));
  }
  ImageSequences found = find_image_sequences(capture);
  if (found.cameras.size() < 2)
    throw InputError(fmt::format(
        "{}: --layout rig is given, but there are no numbered images of several cameras; expected "
        "a folder a camera (cam00/000000.jpg) or names like cam00_000000.jpg",
        capture.string()));
  return found;
}

std::vector<fs::path> subfolders(const fs::path& folder, const fs::path& out) {
  std::error_code reason;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, reason)) {
    std::error_code unresolved;
    const bool is_folder = entry.is_directory(unresolved) || unresolved || entry.is_symlink();
    const bool is_hidden = entry.path().filename().string().front() == '.';
    const bool is_file = !unresolved && entry.is_regular_file(unresolved);
    if (!is_folder || is_hidden || is_file) continue;
    if (!out.empty() &&
        fs::weakly_canonical(entry.path(), unresolved) == fs::weakly_canonical(out, unresolved))
      continue;
    found.push_back(entry.path());
  }
  if (reason)
    throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions",
                                 folder.string(), reason.message()));
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::string> captures_in(const fs::path& folder,
                                     std::optional<ImageLayout> image_layout) {
  std::vector<std::string> names;
  for (const fs::path& path : subfolders(folder, {}))
    if (is_capture(path, image_layout)) names.push_back(path.filename().string());
  return names;
}

bool is_folder_of_captures(const fs::path& folder, std::optional<ImageLayout> image_layout) {
  return fs::is_directory(folder) && !is_capture(folder, image_layout) &&
         !captures_in(folder, image_layout).empty();
}

}  // namespace tessera
