// Lists the frames of the clips of a prepared scene.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// Appends the clips of a `tessera` object in the file `path`, and their frames, whose times are on
/// the axis of the scene. Errors: InputError: a damaged entry, a mask that is not there.
void add_clip_frames(const nlohmann::json& object, const std::filesystem::path& path,
                     TransformsCapture& capture);

}  // namespace tessera
