// Writes the description of a prepared scene (ARCHITECTURE.md, "The prepared scene").
#pragma once
#include <filesystem>

#include "ingest/capture/capture.h"

namespace tessera {

/// Writes `folder`/transforms.json. Errors: InputError when it cannot be written.
void write_prepared_scene(const std::filesystem::path& folder, const Capture& scene);

}  // namespace tessera
