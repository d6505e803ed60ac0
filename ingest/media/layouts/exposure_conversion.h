// What: evens out the exposure of a prepared scene's training cameras, in its images on disk.
// Not: held-out cameras: they are neither fitted nor changed, so that scores stay comparable.
#pragma once
#include <filesystem>

#include "ingest/ingest.h"
#include "ingest/layouts/prepared_scene.h"

namespace tessera {

/// `folder` holds the scene as written. Rewrites the images of training cameras and records the
/// gains in `scene` (1 for held-out cameras). Errors: InputError: fewer than two training cameras,
/// or one with several poses.
void even_exposure(const std::filesystem::path& folder, PreparedScene& scene,
                   const IngestProgress& progress);

}  // namespace tessera
