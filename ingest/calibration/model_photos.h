// Tells a COLMAP model of photos from one that calibrates the cameras of a rig.
#pragma once
#include <filesystem>
#include <vector>

namespace tessera {

/// Where photos of a COLMAP model may lie: `capture` itself, where it has images, and its folders
/// images…; where there are none of these, the only folder that holds images.
std::vector<std::filesystem::path> photo_folders(const std::filesystem::path& capture);

/// Whether one of `folders` has a photo that the model in the folder `model` names. A model that
/// cannot be read counts as one of photos, whose reader reports what is wrong with it.
bool names_photos(const std::filesystem::path& model,
                  const std::vector<std::filesystem::path>& folders);

}  // namespace tessera
