// A sample goes by the shortest clip and the first image.
#include "ingest/steps/sample.h"

#include <algorithm>

#include "ingest/images/image_source.h"

namespace tessera {
namespace {

/// A rate that takes a handful of timesteps of the shortest clip.
double sampled_rate(const Capture& capture, const IngestOptions& options) {
  constexpr double kTimesteps = 5;
  double seconds = options.duration.value_or(1e9);
  for (const RigClip& clip : capture.clips) {
    const VideoTimeline& timeline = clip.timeline;
    seconds = std::min(seconds, timeline.seconds(timeline.ticks.size() - 1) - timeline.seconds(0));
  }
  return (kTimesteps - 0.5) / std::max(1e-3, seconds);
}

/// Of the first image, pixels.
int first_width(const Capture& capture) {
  const CaptureFrame& first = capture.frames.front();
  if (first.view < 0) return capture.clips.front().timeline.width;
  const auto& stated = capture.views[size_t(first.view)].intrinsics;
  return stated ? read_image(first.image).width : first.frame.camera.width;
}

}  // namespace

FrameWindow window_of(const Capture& capture, const IngestOptions& options) {
  FrameWindow window{options.start, options.duration, options.fps, options.frames};
  if (options.sample && !window.fps) window.fps = sampled_rate(capture, options);
  return window;
}

double scale_of(const Capture& capture, const IngestOptions& options) {
  constexpr int kWidest = 960;
  if (!options.sample) return options.scale;
  return options.scale * std::min(1.0, double(kWidest) / std::max(1, first_width(capture)));
}

}  // namespace tessera
