// A clip as one Tessera 4D file: a folder of blocks, a single file, or with the player's page.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "tools/export/formats.h"

namespace tessera {

/// Writes the folder of `request`, whose format and --single say what is in it: `frames` (files),
/// `bytes`, `scene_bytes`, `max_gaussians` and counters; of several windows, of which one is in
/// memory at a time, also `windows` and `peak_gaussians`. Errors: as page_head, OutputFolder and of
/// the clip.
nlohmann::json export_tessera4d(const ExportRequest& request, Clip& clip);

}  // namespace tessera
