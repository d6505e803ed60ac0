// A clip that was trained window by window as one Tessera 4D file of windows (a folder, a single
// file, or with the player's page), or as numbered files of one timestep each.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "tools/export/formats.h"
#include "tools/session/windows_folder.h"

namespace tessera {

/// `request.model` means `folder`. The result is as that of TimeFormat::write, with `windows` and
/// `peak_gaussians`. Errors: InputError: a format that holds one model, which asks for the run of a
/// window; windows that are not trained; `scene`, that of the windows, is gone.
nlohmann::json export_windows(const ExportRequest& request, const WindowsFolder& folder);

}  // namespace tessera
