// Renders the image that a page shows while it loads: the view of a held-out camera at the first
// timestep.
#pragma once
#include <string>

#include "recon4d/model/gaussian_set.h"
#include "tools/export/request.h"

namespace tessera {

/// A PNG file, at most 800 pixels wide and high. The camera is the first of the scene's test split,
/// or its first one where it has none. `model`: as exported, in the world of `request`'s cameras.
/// Errors: InputError where the export has no camera.
std::string poster_view(const ExportRequest& request, const GaussianModel& model);

}  // namespace tessera
