// The windows of a clip as one model of lines (lines.h).
#pragma once
#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// The clip in one model. Dynamic Gaussians become plain (motion_form.h), and those that motion
/// nodes carry pieces of lines (carried_lines.h). Of several windows each gives those whose time
/// μ_t lies in its core; `still` has the static set that they share.
GaussianModel line_model(const WindowModels& windows, const GaussianModel& still);

}  // namespace tessera
