// The test images that a page of the player compares with the model.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "recon4d/model/gaussian_set.h"
#include "tools/export/request.h"

namespace tessera {

/// [{name, camera (as a manifest has it), t, image (data address of a JPEG or PNG file)}]: at most
/// six frames of the scene's test split, else of its val split, else of its train split, evenly
/// over them, at most 960 pixels wide. `model`: as exported, in the world of the cameras.
/// Errors: InputError: the scene of the model or of `request.cameras` cannot be read.
nlohmann::json truth_views(const ExportRequest& request, const GaussianModel& model);

}  // namespace tessera
