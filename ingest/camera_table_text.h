// The table of the cameras of a rig as text for a terminal and as JSON. The cells are those of the
// report of a run, too.
#pragma once
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/camera_row.h"

namespace tessera {

inline constexpr size_t kCameraColumnCount = 11;
using CameraCells = std::array<std::string, kCameraColumnCount>;

/// "camera", "size", "fps", … The last column has the notes.
const CameraCells& camera_columns();
/// "–" for what is not known or was not measured.
CameraCells camera_cells(const CameraRow& row);
/// What the columns state, as one sentence a column.
const char* camera_caption();

/// Aligned columns, a line a camera, and a mark before odd ones; of more than 40 cameras the odd
/// ones and how many others there are. Lines without an end of line; none without rows.
std::vector<std::string> camera_table_lines(const std::vector<CameraRow>& rows);

/// [{name, width, height, frames_per_second, frames_in_file, frames_kept, pose_source,
/// pose_error_px, clock_offset_s, clock_offset_frames, clock_error_frames, clock_source, readout_s,
/// gain, roll_degrees, role, leave_out, notes}]; null for what is not known.
nlohmann::json camera_table_json(const std::vector<CameraRow>& rows);

}  // namespace tessera
