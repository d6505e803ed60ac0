// Chooses the frames and loads their pixels; sets the options for the conversion of a sample.
#include "ingest/layouts/thinned_scene.h"

#include <algorithm>

#include "ingest/checks/stations.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/images/image_source.h"
#include "ingest/images/resampling.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// `most` of `count` places, the first and the last among them.
std::vector<size_t> spread(size_t count, int most) {
  std::vector<size_t> places;
  const size_t wanted = std::min(count, size_t(std::max(1, most)));
  for (size_t i = 0; i < wanted; ++i)
    places.push_back(wanted == 1 ? 0 : i * (count - 1) / (wanted - 1));
  return places;
}

std::vector<int> chosen_frames(const Scene& scene, const Thinning& thinning) {
  const std::vector<Station> stations = stations_of(scene);
  std::vector<int> chosen;
  for (const size_t s : spread(stations.size(), thinning.stations))
    for (const size_t i : spread(stations[s].frames.size(), thinning.instants))
      chosen.push_back(stations[s].frames[i]);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void load_pixels(Frame& frame, const std::filesystem::path& file, const Thinning& thinning,
                 std::array<uint8_t, 3> background) {
  Image8 image = read_png(file);
  if (image.channels != 3) image = composite_on(image, background);
  const double scale =
      std::min(1.0, double(thinning.largest) / std::max(image.width, image.height));
  if (scale < 1) {
    const int width = scaled_side(image.width, scale);
    const int height = scaled_side(image.height, scale);
    frame.camera = frame.camera.resized(width, height);
    image = scale_image(image, width, height);
  }
  frame.image = std::move(image);
}

int width_of(const std::filesystem::path& capture, CaptureLayout layout,
             const IngestOptions& options) {
  switch (layout) {
    case CaptureLayout::kN3dv:
    case CaptureLayout::kVideos:
      return probe_video(videos_in(capture).front()).width;
    case CaptureLayout::kColmap:
      return read_capture_model(capture).photos.front().camera.width;
    case CaptureLayout::kTransforms:
      return read_image(read_transforms_capture(capture).frames.front().image).width;
    case CaptureLayout::kLlff:
      return read_llff_poses(capture / "poses_bounds.npy").front().camera.width;
    case CaptureLayout::kSequences:
      return read_image(sequences_of(capture, options.image_layout).front().images.front().file)
          .width;
    case CaptureLayout::kPhotos:
      return 0;
  }
  return 0;
}

/// A rate that takes a handful of timesteps of the shortest clip.
double timesteps_per_second(const std::filesystem::path& capture, CaptureLayout layout,
                            const IngestOptions& options) {
  constexpr double kMoments = 5;
  double seconds = options.duration.value_or(1e9);
  if (layout == CaptureLayout::kSequences)
    for (const ImageSequence& sequence : sequences_of(capture, options.image_layout))
      seconds =
          std::min(seconds, double(sequence.images.back().number - sequence.images.front().number) /
                                *options.image_rate);
  else
    for (const auto& video : videos_in(capture)) {
      const VideoTimeline timeline = read_timeline(video);
      seconds =
          std::min(seconds, timeline.time_base.at(timeline.ticks.back() - timeline.ticks.front()));
    }
  return (kMoments - 0.5) / std::max(1e-3, seconds);
}

}  // namespace

ThinnedScene thinned_scene(const std::filesystem::path& folder, const Thinning& thinning) {
  SceneOptions options;
  options.allow_static = true;
  options.load_pixels = false;
  ThinnedScene thinned;
  thinned.all = load_scene(folder, options);
  for (const TransformsFrame& listed : read_transforms(folder).frames)
    thinned.images.push_back(listed.image);
  const std::vector<int> chosen = chosen_frames(thinned.all, thinning);
  thinned.sample = thinned.all;
  thinned.sample.frames.clear();
  for (const int i : chosen) thinned.sample.frames.push_back(thinned.all.frames[size_t(i)]);
  parallel_for(int64_t(chosen.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto k = size_t(begin); k < size_t(end); ++k)
      load_pixels(thinned.sample.frames[k], thinned.images[size_t(chosen[k])], thinning,
                  thinned.all.background);
  });
  return thinned;
}

IngestReport ingest_sample(const std::filesystem::path& capture,
                           const std::filesystem::path& folder, IngestOptions options,
                           const IngestProgress& progress) {
  constexpr int kWidest = 960;
  constexpr int64_t kMostPoints = 5000;  // enough for shares of what is seen
  options.allow_static = true;
  options.cloud_points = std::min(options.cloud_points, kMostPoints);
  CaptureLayout layout = layout_of(capture, options);
  if (layout == CaptureLayout::kTransforms && !find_colmap_model(capture).empty())
    options.layout = layout = CaptureLayout::kColmap;  // the model has the lenses
  const bool sequences = layout == CaptureLayout::kSequences;
  if (sequences) options.image_rate = options.fps.value_or(kImageRate);
  if (sequences || (!options.fps && row_of(layout).clips))
    options.fps = timesteps_per_second(capture, layout, options);
  options.scale *= std::min(1.0, double(kWidest) / std::max(1, width_of(capture, layout, options)));
  return ingest_capture(capture, folder, options, progress);
}

}  // namespace tessera
