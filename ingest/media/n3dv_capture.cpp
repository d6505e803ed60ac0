// What: one video a camera beside poses_bounds.npy (Neural 3D Video, LLFF order) → prepared scene.
// Not: synchronisation: each frame keeps its own presentation time; offsets are recorded as 0.
#include <fmt/format.h>

#include <algorithm>

#include "ingest/capture_layout.h"
#include "ingest/held_out_cameras.h"
#include "ingest/intrinsics.h"
#include "ingest/llff_poses.h"
#include "ingest/media/conversion.h"
#include "ingest/media/mask_source.h"
#include "ingest/media/video_decoder.h"
#include "ingest/point_cloud.h"
#include "ingest/source_hash.h"
#include "ingest/time_normalisation.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

struct VideoCamera {
  std::filesystem::path video;
  std::string name;
  Camera camera;  // in the video's size
  Split split = Split::kTrain;
};

void choose_splits(std::vector<VideoCamera>& cameras, const IngestOptions& options,
                   IngestReport& report) {
  if (options.held_out.empty()) {
    if (cameras.size() > 1) cameras.front().split = Split::kTest;
    if (cameras.size() == 1)
      report.warnings.push_back("n3dv: there is one camera only, none is held out for testing");
    return;
  }
  std::vector<std::string> names;
  for (const VideoCamera& camera : cameras) names.push_back(camera.name);
  const std::vector<Split> splits = held_out_splits_of(names, options.held_out, "n3dv");
  for (size_t i = 0; i < cameras.size(); ++i) cameras[i].split = splits[i];
}

std::vector<VideoCamera> read_cameras(const std::filesystem::path& capture,
                                      const IngestOptions& options, IngestReport& report) {
  const auto videos = videos_in(capture);
  const auto poses = read_llff_poses(capture / "poses_bounds.npy");
  if (poses.size() != videos.size())
    throw InputError(fmt::format(
        "n3dv: poses_bounds.npy has {} rows, the folder has {} videos; remove the videos without "
        "a pose or add the missing ones ({})",
        poses.size(), videos.size(), capture.string()));
  std::vector<VideoCamera> cameras;
  for (size_t i = 0; i < videos.size(); ++i) {
    const VideoStream stream = probe_video(videos[i]);
    const Camera& stated = poses[i].camera;
    if (!same_shape(stated.width, stated.height, stream.width, stream.height))
      throw InputError(fmt::format(
          "n3dv: {} is {}x{}, poses_bounds.npy states {}x{}; use videos of the shape that the "
          "poses were made for",
          videos[i].filename().string(), stream.width, stream.height, stated.width, stated.height));
    cameras.push_back({videos[i], videos[i].stem().string(),
                       stated.resized(stream.width, stream.height), Split::kTrain});
  }
  choose_splits(cameras, options, report);
  return cameras;
}

/// Writes decoded pictures in parallel, a bounded number at a time.
class PictureQueue {
 public:
  PictureQueue(const std::filesystem::path& folder, double scale)
      : folder_(folder), scale_(scale) {}

  void add(const std::string& file_path, Image8 image) {
    waiting_.push_back({file_path, std::move(image)});
    if (int(waiting_.size()) >= 2 * thread_count()) write();
  }
  void write() {
    parallel_for(int64_t(waiting_.size()), 1, [&](int64_t begin, int64_t end) {
      for (auto i = size_t(begin); i < size_t(end); ++i)
        write_prepared_picture(folder_ / waiting_[i].file_path, std::move(waiting_[i].image),
                               scale_);
    });
    waiting_.clear();
  }

 private:
  struct Waiting {
    std::string file_path;
    Image8 image;
  };
  std::filesystem::path folder_;
  double scale_;
  std::vector<Waiting> waiting_;
};

struct N3dvWork {
  const std::filesystem::path& folder;
  const IngestOptions& options;
  const IngestProgress& progress;
  int64_t expected_frames = 0;  // of each camera, for the progress report; 0 when unknown
  size_t camera_count = 0;
};

/// Decodes one camera into `scene`; returns its number of frames.
int64_t convert_camera(const N3dvWork& work, const VideoCamera& source, PreparedScene& scene,
                       std::vector<double>& seconds) {
  const int64_t limit = work.options.frames.value_or(INT64_MAX);
  const Camera prepared_camera = scaled_camera(source.camera, work.options.scale);
  const Rational clock = probe_video(source.video).time_base;
  const std::string doing = "decoding " + source.video.filename().string();
  const auto total = work.expected_frames * int64_t(work.camera_count);
  const std::string mask_path =
      prepare_camera_mask(work.folder, source.name, source.camera, {}, source.camera, work.options);
  PictureQueue queue(work.folder, work.options.scale);
  int64_t number = 0;
  decode_video(source.video, [&](VideoFrame decoded) {
    PreparedFrame prepared;
    prepared.frame.name = fmt::format("{}/{:05}", source.name, number);
    prepared.file_path = prepared.frame.name + ".png";
    prepared.frame.camera_name = source.name;
    prepared.frame.frame_number = number++;
    prepared.frame.split = source.split;
    prepared.frame.camera = prepared_camera;
    prepared.ticks = decoded.ticks;
    prepared.mask_path = mask_path;
    seconds.push_back(clock.at(decoded.ticks));
    queue.add(prepared.file_path, std::move(decoded.image));
    scene.frames.push_back(std::move(prepared));
    work.progress(doing, int64_t(scene.frames.size()), total);
    return number < limit;
  });
  queue.write();
  scene.cameras.push_back({source.name, clock, 0});
  scene.sources.push_back({source.video.filename().string(), source_hash(source.video)});
  return number;
}

void check_count(const VideoCamera& camera, int64_t count, const VideoCamera& first,
                 int64_t first_count, const IngestOptions& options) {
  const std::string name = camera.video.filename().string();
  if (options.frames && count < *options.frames)
    throw InputError(fmt::format("n3dv: {} has {} frames, --frames asks for {}; pass --frames {}",
                                 name, count, *options.frames, count));
  if (count != first_count)
    throw InputError(fmt::format("n3dv: {} has {} frames, {} has {}; pass --frames {}", name, count,
                                 first.video.filename().string(), first_count,
                                 std::min(count, first_count)));
}

}  // namespace

Converted convert_n3dv(const std::filesystem::path& capture, const std::filesystem::path& folder,
                       const IngestOptions& options, const IngestProgress& progress) {
  IngestReport report;
  const auto cameras = read_cameras(capture, options, report);
  PreparedScene scene;
  scene.layout = "n3dv";
  scene.scale = options.scale;
  scene.background = "opaque";
  N3dvWork work{folder, options, progress,
                options.frames.value_or(probe_video(cameras.front().video).frames), cameras.size()};
  std::vector<double> seconds;
  for (const VideoCamera& camera : cameras) {
    const int64_t count = convert_camera(work, camera, scene, seconds);
    if (&camera == &cameras.front()) work.expected_frames = count;
    check_count(camera, count, cameras.front(), work.expected_frames, options);
  }
  const bool one_instant = options.allow_static || options.frames == 1;
  const NormalisedTimes times = normalise_times(seconds, one_instant, capture.string());
  for (size_t i = 0; i < scene.frames.size(); ++i) scene.frames[i].frame.time = times.time[i];
  scene.time_axis = times.axis;
  scene.time_base = scene.cameras.front().time_base;
  scene.is_static = times.is_static;
  scene.sources.push_back({"poses_bounds.npy", source_hash(capture / "poses_bounds.npy")});
  PointCloud points = find_points(capture, "", report.warnings);
  report.frames = int64_t(scene.frames.size());
  report.cameras = int64_t(cameras.size());
  return {std::move(scene), std::move(points), std::move(report)};
}

}  // namespace tessera
