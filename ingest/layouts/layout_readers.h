// The readers of the layouts. Each makes a capture of what a folder states: cameras, image files,
// splits. No image is decoded; poses, times and choices that need the pixels come in later steps.
#pragma once
#include <filesystem>

#include "ingest/capture/capture.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/ingest.h"

namespace tessera {

/// options.layout is set. Errors: InputError naming the file and the remedy.
using LayoutReader = Capture(const std::filesystem::path& folder, const IngestOptions& options);

LayoutReader read_transforms_layout;  // images listed in transforms*.json
LayoutReader read_colmap_layout;      // photos posed by a COLMAP model
LayoutReader read_llff_layout;        // photos beside poses_bounds.npy, a row each
LayoutReader read_photo_layout;       // photos without poses
LayoutReader read_clip_layout;        // a video or a sequence of images a camera

/// The photos of `model` below capture.photos become the frames and cameras of `capture`, which are
/// those of a scene that stands still, its points those of `capture`. A photo that is not there has
/// no image; choose_splits() counts it and leaves it out. Errors: InputError: no photo is there;
/// with `strict` one is missing, or an image is not in the model.
void take_photos(ColmapModel model, bool strict, Capture& capture);

}  // namespace tessera
