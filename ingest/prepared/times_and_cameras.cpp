// Frames of cameras that are not those of the folders are numbered by time, others as listed.
#include "ingest/prepared/times_and_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

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

/// In the order of `order`, where none is stated.
void number_frames(TransformsCapture& capture, const std::vector<size_t>& order) {
  std::map<std::string, int64_t> next;
  for (const size_t i : order) {
    TransformsFrame& frame = capture.frames[i];
    if (frame.frame_number < 0) frame.frame_number = next[frame.camera_name]++;
  }
}

std::vector<size_t> listed_order(const TransformsCapture& capture) {
  std::vector<size_t> order(capture.frames.size());
  std::iota(order.begin(), order.end(), size_t(0));
  return order;
}

std::vector<UngroupedFrame> ungrouped(const TransformsCapture& capture,
                                      const std::vector<int>& views) {
  std::vector<UngroupedFrame> frames;
  for (size_t i = 0; i < views.size(); ++i) {
    const TransformsFrame& frame = capture.frames[i];
    frames.push_back({frame.name, frame.camera_name, frame.camera_is_stated, frame.split,
                      *frame.time, views[i]});
  }
  return frames;
}

}  // namespace

void set_path_times(TransformsCapture& capture) {
  number_frames(capture, listed_order(capture));
  check_times(capture);
}

void set_times_and_cameras(TransformsCapture& capture) {
  if (capture.prepared_axis) return set_path_times(capture);
  const std::vector<int> views = view_numbers(capture.frames);
  choose_times(capture, views);
  check_times(capture);
  std::vector<size_t> order = listed_order(capture);
  if (has_time(capture.frames.front())) {
    CameraGroups groups = group_cameras(ungrouped(capture, views));
    for (const size_t i : order) capture.frames[i].camera_name = std::move(groups.cameras[i]);
    if (groups.regrouped) {
      capture.notes.push_back(fmt::format("{}: {}", capture.files.front().string(), groups.note));
      std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return *capture.frames[a].time < *capture.frames[b].time;
      });
    }
  }
  number_frames(capture, order);
}

}  // namespace tessera
