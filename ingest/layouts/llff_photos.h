// What: photos beside poses_bounds.npy (LLFF), one row a photo in the order of their names.
// Not: videos (ingest/layouts/video_capture.cpp), and no point cloud: LLFF's file has none.
#pragma once
#include <filesystem>

#include "ingest/colmap/colmap_model.h"

namespace tessera {

/// The images directly in `images`, by name, each with its row of `poses`, as photos of a
/// model without points. Errors: InputError: as read_llff_poses, or another number of rows than of
/// images.
ColmapModel read_llff_photos(const std::filesystem::path& poses,
                             const std::filesystem::path& images);

}  // namespace tessera
