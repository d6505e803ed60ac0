// What: `tessera export --format splatv`: one file that some players play in continuous time.
// Not: its layout (static3d/splatv.h), nor the other formats (cmd_export.cpp).
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

#include "recon4d/gaussian_set.h"

namespace tessera {

inline constexpr const char* kSplatv = "splatv";  // of --format

/// model.splatv in a folder, with one camera in front of the scene. Returns what `export --json`
/// says of it. Errors: InputError: the folder has files that are not ours, too many Gaussians.
nlohmann::json export_splatv(const std::filesystem::path& folder, const GaussianModel& model,
                             bool overwrite);

}  // namespace tessera
