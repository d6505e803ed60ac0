// Frames of clips are listed here; frames that a transforms file lists are counted by their times.
// The times of all are normalised together.
#include <fmt/format.h>

#include <map>
#include <set>

#include "ingest/clocks/timesteps.h"
#include "ingest/steps/clip_times.h"
#include "ingest/steps/kept_frames.h"
#include "ingest/steps/sample.h"
#include "ingest/steps/steps.h"

namespace tessera {
namespace {

/// The frame `index` of clip `i`, the `number`-th of those that are kept, at `time`.
CaptureFrame frame_of(const Capture& capture, size_t i, size_t index, int64_t number, double time) {
  const RigClip& clip = capture.clips[i];
  CaptureFrame frame;
  frame.frame.name = fmt::format("{}/{:05}", clip.name, number);
  frame.frame.camera_name = clip.name;
  frame.frame.frame_number = number;
  frame.frame.time = time;
  frame.frame.split = capture.held_out[i] ? Split::kTest : Split::kTrain;
  frame.frame.camera = clip.camera->camera;
  frame.ticks = clip.timeline.ticks[index];
  frame.file_path = frame.frame.name + ".png";
  return frame;
}

/// Keeps the frames of each camera's first `count` instants (its first images without times).
void keep_first_instants(Capture& capture, int64_t count) {
  std::map<std::string, std::set<double>> instants;
  const auto instant_of = [&](const CaptureFrame& frame) {
    return capture.is_timed ? frame.frame.time : double(frame.frame.frame_number);
  };
  for (const CaptureFrame& frame : capture.frames)
    instants[frame.frame.camera_name].insert(instant_of(frame));
  std::erase_if(capture.frames, [&](const CaptureFrame& frame) {
    const std::set<double>& of_camera = instants[frame.frame.camera_name];
    return std::distance(of_camera.begin(), of_camera.find(instant_of(frame))) >= count;
  });
}

}  // namespace

Capture choose_frames(Capture capture, const StepContext& context) {
  if (capture.clips.empty() && context.options.frames)
    keep_first_instants(capture, *context.options.frames);
  if (capture.clips.empty() || !capture.frames.empty()) return capture;
  const auto times = clip_times(capture);
  const auto kept = kept_frames(capture, window_of(capture, context.options), times);
  for (size_t i = 0; i < kept.size(); ++i)
    for (size_t k = 0; k < kept[i].size(); ++k)
      capture.frames.push_back(frame_of(capture, i, kept[i][k], int64_t(k), times[i][kept[i][k]]));
  return capture;
}

Capture set_times(Capture capture, const StepContext& context) {
  capture.is_static = true;
  capture.time_axis = capture.stated_axis.value_or(TimeAxis{});
  std::vector<double> stated;
  for (const CaptureFrame& frame : capture.frames) stated.push_back(frame.frame.time);
  NormalisedTimes times{std::vector<double>(stated.size(), 0.0), capture.time_axis, true};
  if (capture.is_timed) {
    const IngestOptions& options = context.options;
    const bool one_timestep =
        options.allow_static || (!capture.clips.empty() && options.frames == 1);
    times = normalise_times(stated, one_timestep, capture.times_from.string());
    if (capture.stated_axis && !times.is_static) times = {stated, *capture.stated_axis, false};
  }
  for (size_t i = 0; i < stated.size(); ++i) capture.frames[i].frame.time = times.time[i];
  capture.time_axis = times.axis;
  capture.is_static = times.is_static;
  return capture;
}

}  // namespace tessera
