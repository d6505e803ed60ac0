// The section of a run's report about the cameras of its rig: the rows as the run stored them, and
// the table as HTML.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/camera_row.h"

namespace tessera {

/// The rows of what camera_table_json() made; entries that are no objects are left out, and fields
/// that are missing or of another type are as if they were not known. Empty of anything else.
std::vector<CameraRow> camera_rows(const nlohmann::json& table);

/// "Cameras" with a table that scrolls in a box; odd cameras are marked. All text is escaped.
/// Nothing without rows.
std::string camera_section(const std::vector<CameraRow>& rows);

}  // namespace tessera
