// What: photos beside poses_bounds.npy (LLFF), one row a photo in the order of their names.
// Not: videos (media/video_capture.cpp), and no point cloud: LLFF's file has none.
#pragma once
#include <filesystem>

#include "ingest/poses/colmap_model.h"

namespace tessera {

/// The pictures directly in `pictures`, by name, each with its row of `poses`, as photos of a
/// model without points. Errors: InputError: as read_llff_poses, or another number of rows than of
/// pictures.
ColmapModel read_llff_photos(const std::filesystem::path& poses,
                             const std::filesystem::path& pictures);

}  // namespace tessera
