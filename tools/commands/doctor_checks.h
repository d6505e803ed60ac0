// What: runs every check on a scene and gathers findings and tables.
// Not: the way from a capture to a scene (commands/doctor.cpp).
#pragma once
#include "ingest/layouts/thinned_scene.h"
#include "tools/commands/doctor_report.h"

namespace tessera {

/// Adds to `report`. `folder`: where the scene was read from, for its recorded clock offsets.
void examine(const ThinnedScene& scene, const std::filesystem::path& folder, DoctorReport& report);

}  // namespace tessera
