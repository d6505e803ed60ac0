// The windows of a clip as one model of lines (lines.h).
#pragma once
#include <string>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// The clip in one model. Dynamic Gaussians become plain (motion_form.h). Of several windows each
/// gives those whose time μ_t lies in its core; `still` has the static set that they share. Errors:
/// InputError that begins with `where`: motion nodes.
GaussianModel line_model(const WindowModels& windows, const GaussianModel& still,
                         const std::string& where);

}  // namespace tessera
