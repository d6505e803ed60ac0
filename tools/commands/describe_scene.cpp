// Describes prepared scenes, transforms folders, captures of videos, of numbered images and of
// photos. Sizes come from the headers of the images and lengths from those of the videos; no pixels
// are decoded.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/json_file.h"
#include "ingest/files/png.h"
#include "ingest/images/image_paths.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/layouts/unread_files.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/prepared/transforms_json.h"
#include "recon4d/evaluation/evaluate.h"
#include "tools/commands/describe.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Sizes {
  std::map<std::pair<int, int>, int64_t> frames;  // by width and height
  int64_t with_alpha = 0, not_png = 0, in_videos = 0;
};

Sizes image_sizes(const TransformsCapture& capture) {
  Sizes sizes;
  for (const TransformsFrame& frame : capture.frames) {
    if (frame.clip >= 0) {
      ++sizes.in_videos;
      ++sizes.frames[{frame.camera.width, frame.camera.height}];
      continue;
    }
    if (frame.image.extension() != ".png" && frame.image.extension() != ".PNG") {
      ++sizes.not_png;
      continue;
    }
    const Image8 image = read_png_size(frame.image);
    ++sizes.frames[{image.width, image.height}];
    sizes.with_alpha += image.channels == 4;
  }
  return sizes;
}

json sizes_json(const Sizes& sizes) {
  json list = json::array();
  for (const auto& [size, frames] : sizes.frames)
    list.push_back({{"width", size.first}, {"height", size.second}, {"frames", frames}});
  return list;
}

/// `moments` is the key of versions before 0.3.
void put_timesteps(size_t count, json& info) {
  info["timesteps"] = info["moments"] = count;
}

/// The `tessera` object without its long lists.
void put_preparation(const fs::path& folder, json& info) {
  const json object = read_json(folder / "transforms.json").at("tessera");
  for (const auto& [key, value] : object.items())
    if (value.is_primitive()) info["preparation"][key] = value;
}

}  // namespace

json describe_transforms(const fs::path& folder) {
  const TransformsCapture capture = read_transforms(folder);
  const bool prepared = is_prepared_scene(folder);
  json info = {{"kind", prepared ? "prepared scene" : "transforms folder (D-NeRF layout)"},
               {"path", folder.string()},
               {"layout", "transforms"},
               {"frames", capture.frames.size()}};
  std::set<std::string> cameras;
  std::map<std::string, int64_t> splits;
  for (const TransformsFrame& frame : capture.frames) {
    cameras.insert(frame.camera_name);
    ++splits[name_of(frame.split)];
  }
  info["splits"] = splits;
  info["cameras"] = cameras.size();
  info["camera_names"] = cameras;
  const NormalisedTimes times = times_of(capture, true);
  info["is_static"] = times.is_static;
  std::vector<FrameTime> frames;
  for (size_t i = 0; i < times.time.size(); ++i)
    frames.push_back({capture.frames[i].camera_name, times.time[i], capture.frames[i].split});
  const std::vector<int64_t> numbers = timestep_numbers(frames);
  put_timesteps(std::set<int64_t>(numbers.begin(), numbers.end()).size(), info);
  info["time_axis"] = {{"origin", times.axis.origin}, {"duration", times.axis.duration}};
  const Sizes sizes = image_sizes(capture);
  info["sizes"] = sizes_json(sizes);
  info["frames_with_alpha"] = sizes.with_alpha;
  info["background"] = sizes.with_alpha > 0 ? "alpha: composited on --background" : "opaque";
  if (sizes.not_png > 0) info["frames_not_png"] = sizes.not_png;
  if (sizes.in_videos > 0) info["frames_in_videos"] = sizes.in_videos;
  if (prepared) put_preparation(folder, info);
  if (!capture.warnings.empty()) info["warnings"] = capture.warnings;
  if (!capture.notes.empty()) info["notes"] = capture.notes;
  return info;
}

json describe_videos(const fs::path& folder) {
  const bool has_poses = fs::exists(folder / "poses_bounds.npy");
  json info = {{"kind", "capture of videos"},
               {"path", folder.string()},
               {"layout", has_poses ? "n3dv" : "videos"}};
  json names = json::array();
  int64_t bytes = 0;
  const std::vector<VideoCamera> cameras = video_cameras(folder);
  for (const VideoCamera& camera : cameras)
    for (const fs::path& video : camera.files) {
      names.push_back(video.lexically_relative(folder).string());
      bytes += int64_t(fs::file_size(video));
    }
  info["cameras"] = cameras.size();
  info["videos"] = names;
  info["bytes"] = bytes;
  if (has_poses) {
    const std::vector<LlffPose> poses = read_llff_poses(folder / "poses_bounds.npy");
    info["poses"] = poses.size();
    const Camera& first = poses.front().camera;
    info["sizes"] = {{{"width", first.width}, {"height", first.height}}};
    info["focal"] = first.fl_x;
    double low = poses.front().near, high = poses.front().far;
    for (const LlffPose& pose : poses) {
      low = std::min(low, pose.near);
      high = std::max(high, pose.far);
    }
    info["depth"] = {low, high};
  }
  return info;
}

std::optional<json> describe_sequences(const fs::path& folder) {
  const ImageSequences found = find_image_sequences(folder);
  if (found.evidence == RigEvidence::kNone) return std::nullopt;
  std::string reading = reading_text(found.cameras.size(), found.times, kImageRate);
  try {
    if (detect_layout(folder) != CaptureLayout::kSequences) return std::nullopt;
  } catch (const AmbiguousCapture& unclear) {
    reading = unclear.what();
  }
  json info = {{"kind", "capture of image sequences"},
               {"path", folder.string()},
               {"layout", "sequences"},
               {"reading", reading},
               {"cameras", found.cameras.size()}};
  json names = json::array();
  int64_t frames = 0;
  std::set<int64_t> numbers;
  for (const ImageSequence& sequence : found.cameras) {
    names.push_back(sequence.camera);
    frames += int64_t(sequence.images.size());
    for (const NumberedImage& image : sequence.images) numbers.insert(image.number);
  }
  info["camera_names"] = names;
  info["frames"] = frames;
  put_timesteps(numbers.size(), info);
  return info;
}

std::optional<json> describe_photos(const fs::path& folder) {
  IngestOptions options;
  try {
    options.layout = detect_layout(folder);
  } catch (const InputError&) {
    return std::nullopt;  // no capture, or one that names what is unclear when it is prepared
  }
  const LayoutRow& row = row_of(*options.layout);
  if (!row.photos) return std::nullopt;
  const Capture capture = row.read(folder, options);
  json info = {{"kind", "capture of photos"},
               {"path", folder.string()},
               {"layout", row.name},
               {"posed", capture.posed},
               {"points", capture.points.position.size()}};
  std::map<std::pair<int, int>, int64_t> sizes;  // as the poses state them
  for (const CaptureFrame& frame : capture.frames)
    if (!frame.image.empty()) ++sizes[{frame.frame.camera.width, frame.frame.camera.height}];
  info["frames"] = capture.posed ? capture.cameras.size() : images_in(capture.photos).size();
  if (capture.posed) info["sizes"] = sizes_json({sizes, 0, 0});
  std::vector<std::string> warnings = capture.warnings;
  const UnreadFiles unread = unread_files(folder, taken_files(capture), options.masks, false);
  warnings.insert(warnings.end(), unread.warnings.begin(), unread.warnings.end());
  if (std::string line = unused_masks(folder); !line.empty()) warnings.push_back(std::move(line));
  if (!warnings.empty()) info["warnings"] = warnings;
  if (!capture.notes.empty()) info["notes"] = capture.notes;
  return info;
}

}  // namespace tessera
