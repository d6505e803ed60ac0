// Measures the clocks of the clips, or takes the stated ones, and records them with the cameras.
#include "ingest/clocks/clock_note.h"
#include "ingest/clocks/clock_sync.h"
#include "ingest/steps/clip_times.h"
#include "ingest/steps/steps.h"

namespace tessera {
namespace {

CaptureCamera camera_of(const RigClip& clip, const ClipClock& clock) {
  CaptureCamera camera{.name = clip.name, .time_base = clip.timeline.time_base};
  camera.time_offset = clock.offset;
  camera.time_uncertainty = clock.uncertainty;
  camera.time_measured = clock.measured;
  camera.time_source = clock.source;
  note_removed_lens(camera, {clip.camera->lens_model, clip.camera->lens});
  return camera;
}

}  // namespace

Capture align_clocks(Capture capture, const StepContext& context) {
  if (capture.clips.empty() || !capture.frames.empty()) return capture;  // a moving camera has some
  const ClipClocks clocks = synchronise(capture.clips, context.options.sync, context.progress);
  capture.warnings.insert(capture.warnings.end(), clocks.warnings.begin(), clocks.warnings.end());
  capture.notes.insert(capture.notes.end(), clocks.notes.begin(), clocks.notes.end());
  if (capture.clips.size() > 1)
    capture.notes.push_back(clock_note(clip_names(capture), clocks.clocks));
  for (size_t i = 0; i < capture.clips.size(); ++i)
    capture.cameras.push_back(camera_of(capture.clips[i], clocks.clocks[i]));
  capture.time_base = capture.cameras.front().time_base;
  return capture;
}

std::vector<std::vector<double>> clip_times(const Capture& capture) {
  std::vector<std::vector<double>> times;
  for (size_t i = 0; i < capture.clips.size(); ++i) {
    std::vector<double>& of_clip = times.emplace_back();
    const VideoTimeline& timeline = capture.clips[i].timeline;
    for (size_t k = 0; k < timeline.ticks.size(); ++k)
      of_clip.push_back(timeline.seconds(k) + capture.cameras[i].time_offset);
  }
  return times;
}

}  // namespace tessera
