// The files that `tessera run` makes of its model, or of the windows of a clip: PLY frames and the
// player page.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "ingest/scene.h"
#include "tools/session/run_folder.h"

namespace tessera {

/// `count` PLY frames, evenly from the first timestep to the last, and their manifest. Returns
/// `folder`, `frames` and `bytes`.
nlohmann::json write_run_frames(const RunFolder& run, const std::filesystem::path& folder,
                                int64_t count);

/// One page that opens by itself, or a folder for a web server where that would be too much for a
/// browser to open in one piece, as of a clip in windows, with a poster of a held-out camera.
/// Returns `folder`, `format` (html or page), `bytes` and more.
nlohmann::json write_run_player(const RunFolder& run, const std::filesystem::path& folder,
                                const std::string& title, const std::string& description);

/// The word for `tessera render --path` that shows what the training cameras saw: "orbit", or
/// "spiral" where they all look one way.
std::string camera_path_of(const Scene& scene);

}  // namespace tessera
