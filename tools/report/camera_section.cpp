// Reads the stored rows field by field, and writes the cells of the terminal's table as HTML.
#include "tools/report/camera_section.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/camera_table_text.h"
#include "tools/report/log_events.h"
#include "tools/web/page_words.h"

namespace tessera {
namespace {

using nlohmann::json;

CameraRow row_of_json(const json& entry) {
  CameraRow row;
  row.name = text_at(entry, "name");
  row.width = int(count_at(entry, "width"));
  row.height = int(count_at(entry, "height"));
  row.frames_per_second = number_at(entry, "frames_per_second").value_or(0);
  row.frames_in_file = count_at(entry, "frames_in_file");
  row.frames_kept = count_at(entry, "frames_kept");
  row.pose_source = text_at(entry, "pose_source");
  row.pose_error = number_at(entry, "pose_error_px");
  row.clock_offset = number_at(entry, "clock_offset_s").value_or(0);
  row.clock_offset_frames = number_at(entry, "clock_offset_frames").value_or(0);
  row.clock_source = text_at(entry, "clock_source");
  row.gain = number_at(entry, "gain");
  row.roll = number_at(entry, "roll_degrees");
  row.test = text_at(entry, "role") == "test";
  row.leave_out = field_at(entry, "leave_out") == true;
  if (const json& notes = field_at(entry, "notes"); notes.is_array())
    for (const json& note : notes)
      if (note.is_string()) row.notes.push_back(note.get<std::string>());
  return row;
}

std::string line_of(const CameraCells& cells, const char* element) {
  std::string html;
  for (const std::string& cell : cells)
    html += fmt::format("<{0}>{1}</{0}>", element, html_text(cell));
  return html;
}

}  // namespace

std::vector<CameraRow> camera_rows(const json& table) {
  std::vector<CameraRow> rows;
  if (!table.is_array()) return rows;
  for (const json& entry : table)
    if (entry.is_object()) rows.push_back(row_of_json(entry));
  return rows;
}

std::string camera_section(const std::vector<CameraRow>& rows) {
  if (rows.empty()) return "";
  std::string lines;
  for (const CameraRow& row : rows)
    lines += fmt::format("<tr{}>{}</tr>\n", row.is_odd() ? " class=\"odd\"" : "",
                         line_of(camera_cells(row), "td"));
  return fmt::format(
      "<h2>Cameras</h2>\n<div class=\"card\"><div class=\"wide\"><table class=\"cameras\">\n"
      "<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table></div>\n<p "
      "class=\"soft\">{}.</p></div>\n",
      line_of(camera_columns(), "th"), lines, html_text(camera_caption()));
}

}  // namespace tessera
