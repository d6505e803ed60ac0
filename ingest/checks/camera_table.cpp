// Compares the rows with each other, column by column.
#include "ingest/checks/camera_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "ingest/capture/capture.h"
#include "ingest/clocks/frame_rates.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

CameraRow row_of_clip(const RigClip& clip, const CaptureCamera& camera) {
  CameraRow row;
  row.name = clip.name;
  row.width = clip.timeline.width;
  row.height = clip.timeline.height;
  row.frames_in_file = int64_t(clip.timeline.ticks.size());
  row.clock_offset = camera.time_offset;
  row.clock_source = camera.time_source;
  if (const double seconds = clip.timeline.frame_seconds; seconds > 0) {
    row.frames_per_second = 1 / seconds;
    row.clock_offset_frames = camera.time_offset / seconds;
    if (camera.time_source != "none") row.clock_error = camera.time_uncertainty / seconds;
  }
  if (clip.camera) row.readout = clip.camera->camera.readout;
  row.pose_source = clip.camera && clip.camera->estimated ? "COLMAP" : "stated";
  if (clip.camera) row.pose_error = clip.camera->reprojection_error;
  return row;
}

void count_frames(const Capture& capture, std::vector<CameraRow>& rows) {
  std::map<std::string, int64_t> kept;
  for (const CaptureFrame& frame : capture.frames) ++kept[frame.frame.camera_name];
  for (CameraRow& row : rows) row.frames_kept = kept[row.name];
}

void mark_sizes(std::vector<CameraRow>& rows) {
  std::map<std::pair<int, int>, int64_t> counts;
  for (const CameraRow& row : rows) ++counts[{row.width, row.height}];
  const auto usual =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  for (CameraRow& row : rows)
    if (std::pair(row.width, row.height) != usual->first) row.notes.push_back("other size");
}

void leave_out(const char* why, CameraRow& row) {
  row.notes.push_back(why);
  row.leave_out = true;
}

void mark_rates(const Capture& capture, std::vector<CameraRow>& rows) {
  std::vector<double> frame_seconds;
  for (const RigClip& clip : capture.clips) frame_seconds.push_back(clip.timeline.frame_seconds);
  const std::vector<char> odd = odd_rates(frame_seconds);
  for (size_t i = 0; i < rows.size(); ++i)
    if (odd[i]) leave_out("other rate", rows[i]);
}

void mark_clocks(std::vector<CameraRow>& rows) {
  const auto is_unknown = [](const CameraRow& row) { return row.clock_source == "none"; };
  if (std::all_of(rows.begin(), rows.end(), is_unknown)) return;  // none was asked for
  for (CameraRow& row : rows)
    if (is_unknown(row)) row.notes.push_back("clock unknown");
}

void mark_pose_errors(std::vector<CameraRow>& rows) {
  constexpr double kFar = 3, kVisible = 1;  // of the median; pixels
  std::vector<double> errors;
  for (const CameraRow& row : rows)
    if (row.pose_error) errors.push_back(*row.pose_error);
  if (errors.empty()) return;
  const double limit = std::max(kVisible, kFar * lower_median(std::move(errors)));
  for (CameraRow& row : rows)
    if (row.pose_error && *row.pose_error >= limit) leave_out("large pose error", row);
}

CameraRow* find_row(const std::string& name, std::vector<CameraRow>& rows) {
  const auto found = std::find_if(rows.begin(), rows.end(),
                                  [&](const CameraRow& row) { return row.name == name; });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace

std::vector<CameraRow> camera_table(const Capture& capture) {
  std::vector<CameraRow> rows;
  if (capture.clips.size() < 2) return rows;
  check(capture.cameras.size() == capture.clips.size(), "camera_table: a camera for each clip");
  for (size_t i = 0; i < capture.clips.size(); ++i) {
    rows.push_back(row_of_clip(capture.clips[i], capture.cameras[i]));
    rows.back().test = capture.held_out[i] != 0;
  }
  count_frames(capture, rows);
  mark_sizes(rows);
  mark_rates(capture, rows);
  for (const std::string& name : capture.partial)
    if (CameraRow* row = find_row(name, rows)) row->notes.push_back("part of the clip");
  mark_clocks(rows);
  mark_pose_errors(rows);
  return rows;
}

void put_gains(const std::vector<CameraGain>& gains, std::vector<CameraRow>& rows) {
  constexpr double kDark = 0.8, kBright = 1.25;
  for (const CameraGain& camera : gains) {
    CameraRow* const row = find_row(camera.camera, rows);
    if (row == nullptr || camera.pairs < kLeastColourPairs) continue;
    row->gain = (camera.gain[0] + camera.gain[1] + camera.gain[2]) / 3;
    if (*row->gain < kDark) row->notes.push_back("dark");
    if (*row->gain > kBright) row->notes.push_back("bright");
  }
}

void put_rolls(const std::vector<CameraRoll>& rolls, std::vector<CameraRow>& rows) {
  constexpr double kTurned = 45;
  for (const CameraRoll& camera : rolls) {
    CameraRow* const row = find_row(camera.camera, rows);
    if (row == nullptr || !camera.known) continue;
    row->roll = camera.degrees;
    if (std::abs(camera.degrees) >= kTurned) row->notes.push_back("turned");
  }
}

std::string leave_out_line(const std::vector<CameraRow>& rows) {
  constexpr size_t kEnough = 6;  // one is the test camera
  std::vector<std::string> odd, others;
  for (const CameraRow& row : rows)
    if (row.leave_out)
      odd.push_back(fmt::format("{} ({})", row.name, fmt::join(row.notes, ", ")));
    else
      others.push_back(row.name);
  if (odd.empty() || others.size() < kEnough || 2 * others.size() < rows.size()) return "";
  return fmt::format("leave out {}: --cameras {}", fmt::join(odd, ", "), fmt::join(others, ","));
}

}  // namespace tessera
