// Frames of cameras that are not those of the folders are sorted by time, others stay as listed.
#include "ingest/prepared/times_and_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "ingest/prepared/camera_groups.h"
#include "ingest/prepared/equal_views.h"
#include "ingest/prepared/frame_times.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

bool has_time(const TransformsFrame& frame) {
  return frame.time.has_value();
}

void check_times(const TransformsCapture& capture) {
  const auto& frames = capture.frames;
  if (std::none_of(frames.begin(), frames.end(), has_time)) return;
  const auto without = std::find_if_not(frames.begin(), frames.end(), has_time);
  if (without != frames.end())
    throw InputError(fmt::format(
        "{}: has no time, other frames have one; add it, or remove all times for a static scene",
        without->where));
}

/// In the order of the frames, where no number is stated.
void number_frames(TransformsCapture& capture) {
  std::map<std::string, int64_t> next;
  for (TransformsFrame& frame : capture.frames)
    if (frame.frame_number < 0) frame.frame_number = next[frame.camera_name]++;
}

void sort_by_camera_and_time(std::vector<TransformsFrame>& frames) {
  std::sort(frames.begin(), frames.end(), [](const TransformsFrame& a, const TransformsFrame& b) {
    return std::tie(a.split, a.camera_name, *a.time, a.name) <
           std::tie(b.split, b.camera_name, *b.time, b.name);
  });
}

std::vector<UngroupedFrame> ungrouped(const TransformsCapture& capture,
                                      const std::vector<int>& views) {
  std::vector<UngroupedFrame> frames;
  for (size_t i = 0; i < views.size(); ++i) {
    const TransformsFrame& frame = capture.frames[i];
    frames.push_back({frame.name, frame.camera_name, frame.camera_is_stated, frame.split,
                      *frame.time, views[i], frame.camera_key});
  }
  return frames;
}

/// Gives frames with times their cameras. Where these are not the folders, the frames are sorted,
/// so that the order of the file changes nothing.
void set_cameras(TransformsCapture& capture, const std::vector<int>& views) {
  const CameraGroups groups = group_cameras(ungrouped(capture, views));
  if (!groups.regrouped) return;
  for (size_t i = 0; i < views.size(); ++i) capture.frames[i].camera_name = groups.cameras[i];
  capture.notes.push_back(fmt::format("{}: {}", capture.files.front().string(), groups.note));
  sort_by_camera_and_time(capture.frames);
}

}  // namespace

void set_path_times(TransformsCapture& capture) {
  number_frames(capture);
  check_times(capture);
}

void set_times_and_cameras(TransformsCapture& capture) {
  if (capture.prepared_axis) return set_path_times(capture);
  const std::vector<int> views = view_numbers(capture.frames);
  choose_times(capture, views);
  check_times(capture);
  if (has_time(capture.frames.front())) set_cameras(capture, views);
  number_frames(capture);
}

}  // namespace tessera
