// What: `tessera export` of formats that hold one timestep: numbered files.
// Not: formats that hold time (export/in_time.h).
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "recon4d/model/gaussian_set.h"
#include "tools/export/request.h"

namespace tessera {

/// Writes the folder; frames, bytes and counters. Errors: as export_times, export_sequence.
nlohmann::json export_frames(const ExportRequest& request, const GaussianModel& model);

}  // namespace tessera
