// What: what all layouts have in common once their images are written: the world, exposure, the
//       initial cloud, masks, the file that describes the scene.
// Not: what a layout's converter does (conversion.h).
#pragma once
#include <filesystem>

#include "ingest/layouts/conversion.h"

namespace tessera {

/// Writes points.ply and transforms.json into `folder`, which holds the images. Errors:
/// InputError.
void finish_scene(Converted& converted, CaptureLayout layout, const std::filesystem::path& folder,
                  const IngestOptions& options, const IngestProgress& progress);

}  // namespace tessera
