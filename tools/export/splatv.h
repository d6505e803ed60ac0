// What: `tessera export --format splatv`: one file that some players play in continuous time.
// Not: its layout (static3d/formats/splatv.h), nor the other formats (export/in_time.cpp).
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "recon4d/model/gaussian_set.h"
#include "tools/export/request.h"

namespace tessera {

/// model.splatv with the cameras of the rig, or one in front of the scene. A row's `write` of
/// time_formats().
nlohmann::json write_splatv(const ExportRequest& request, GaussianModel& model);

}  // namespace tessera
