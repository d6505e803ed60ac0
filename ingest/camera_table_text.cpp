// Formats the rows, and aligns them by the widest cell of each column.
#include "ingest/camera_table_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

constexpr const char* kUnknown = "–";

/// Characters, not bytes, of UTF-8.
size_t width_of(const std::string& text) {
  return size_t(std::count_if(text.begin(), text.end(),
                              [](char letter) { return (uint8_t(letter) & 0xC0) != 0x80; }));
}

std::string number_text(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : kUnknown;
}

std::string pose_text(const CameraRow& row) {
  return row.pose_error ? number_text(row.pose_error, 2) : row.pose_source;
}

/// "+0.0417 (+1.00±0.02)".
std::string clock_text(const CameraRow& row) {
  const std::string seconds =
      row.clock_offset == 0 ? "0" : fmt::format("{:+.4f}", row.clock_offset);
  std::string frames;
  if (row.clock_offset != 0 && row.frames_per_second > 0)
    frames = fmt::format("{:+.2f}", row.clock_offset_frames);
  if (row.clock_error > 0) frames += fmt::format("±{:.2f}", row.clock_error);
  return frames.empty() ? seconds : fmt::format("{} ({})", seconds, frames);
}

std::string rate_text_of(const CameraRow& row) {
  if (row.frames_per_second <= 0) return kUnknown;
  return fmt::format("{:g}", std::round(100 * row.frames_per_second) / 100);
}

json known(const std::optional<double>& value) {
  return value ? json(*value) : json();
}

}  // namespace

const CameraCells& camera_columns() {
  static const CameraCells kColumns{"camera", "size", "fps",  "frames", "pose px", "clock s (fr)",
                                    "from",   "gain", "roll", "role",   "notes"};
  return kColumns;
}

CameraCells camera_cells(const CameraRow& row) {
  return {row.name,
          fmt::format("{}x{}", row.width, row.height),
          rate_text_of(row),
          fmt::format("{}/{}", row.frames_kept, row.frames_in_file),
          pose_text(row),
          clock_text(row),
          row.clock_source.empty() ? kUnknown : row.clock_source,
          number_text(row.gain, 2),
          row.roll ? fmt::format("{:.0f}°", std::round(*row.roll) + 0.0) : kUnknown,
          row.test ? "test" : "train",
          fmt::format("{}", fmt::join(row.notes, ", "))};
}

const char* camera_caption() {
  return "frames: kept of those in the file; pose: mean reprojection error of COLMAP's points in "
         "pixels, or where the pose comes from; clock: seconds (frames ± standard error) added, "
         "and "
         "what they come from; gain: brightness by the median camera's; roll: clockwise turn of "
         "the image";
}

std::vector<std::string> camera_table_lines(const std::vector<CameraRow>& rows) {
  constexpr size_t kMostRows = 40;
  if (rows.empty()) return {};
  std::vector<std::pair<bool, CameraCells>> table{{false, camera_columns()}};
  for (const CameraRow& row : rows)
    if (rows.size() <= kMostRows || row.is_odd())
      table.emplace_back(row.is_odd(), camera_cells(row));
  std::array<size_t, kCameraColumnCount> widths{};
  for (const auto& [odd, cells] : table)
    for (size_t k = 0; k < kCameraColumnCount; ++k)
      widths[k] = std::max(widths[k], width_of(cells[k]));
  std::vector<std::string> lines;
  for (const auto& [odd, cells] : table) {
    std::string& line = lines.emplace_back(odd ? "! " : "  ");
    for (size_t k = 0; k < kCameraColumnCount; ++k)
      line += cells[k] + std::string(widths[k] - width_of(cells[k]) + 2, ' ');
    line.erase(line.find_last_not_of(' ') + 1);
  }
  if (const size_t others = rows.size() + 1 - table.size(); others > 0)
    lines.push_back(fmt::format("  and {} cameras in which nothing is odd", others));
  return lines;
}

json camera_table_json(const std::vector<CameraRow>& rows) {
  json table = json::array();
  for (const CameraRow& row : rows)
    table.push_back(
        {{"name", row.name},
         {"width", row.width},
         {"height", row.height},
         {"frames_per_second", row.frames_per_second > 0 ? json(row.frames_per_second) : json()},
         {"frames_in_file", row.frames_in_file},
         {"frames_kept", row.frames_kept},
         {"pose_source", row.pose_source},
         {"pose_error_px", known(row.pose_error)},
         {"clock_offset_s", row.clock_offset},
         {"clock_offset_frames", row.clock_offset_frames},
         {"clock_error_frames", row.clock_error},
         {"clock_source", row.clock_source},
         {"readout_s", row.readout},
         {"gain", known(row.gain)},
         {"roll_degrees", known(row.roll)},
         {"role", row.test ? "test" : "train"},
         {"leave_out", row.leave_out},
         {"notes", row.notes}});
  return table;
}

}  // namespace tessera
