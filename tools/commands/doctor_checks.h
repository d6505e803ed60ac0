// Runs all checks on a scene and collects their findings and tables.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ingest/camera_row.h"
#include "ingest/checks/finding.h"
#include "ingest/derived/thinned_scene.h"
#include "tools/windows/window_choice.h"

namespace tessera {

struct DoctorReport {
  std::string path;
  std::string kind;                // "scene", "capture (a sample of it)"
  std::vector<CameraRow> cameras;  // of a rig of clips; examine() adds gains and rolls
  Findings findings;
  nlohmann::json tables = nlohmann::json::object();  // by check
  double seconds = 0;
};

/// Adds to `report`. `folder`: where the scene was read from, for its recorded clock offsets.
/// `wish`: of windows, for the forecast.
void examine(const ThinnedScene& scene, const std::filesystem::path& folder, const WindowWish& wish,
             DoctorReport& report);

}  // namespace tessera
