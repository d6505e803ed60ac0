// Where the images of a rig lie, whatever its folders are called.
#pragma once
#include <filesystem>
#include <vector>

#include "ingest/layouts/image_sequences.h"

namespace tessera {

/// The sub-folders by name; hidden ones are left out, and a folder that cannot be read has none.
std::vector<std::filesystem::path> folders_in(const std::filesystem::path& folder);

/// The folder with the images of the camera whose folder is given: itself, its `images`, or the
/// only one in it that holds images of colour, beside depths. Empty where there is none, or are
/// several.
std::filesystem::path images_of_camera(const std::filesystem::path& folder);

/// The folders in which those of cameras may stand side by side: `capture`, and those in it that
/// hold no images, `images` first.
std::vector<std::filesystem::path> parents_of_cameras(const std::filesystem::path& capture);

/// Images that lie in a folder a timestep, called as their cameras: frame_3/cam00.png, or
/// frame_3/images/cam00.png. The number of the folder is that of the image. Empty where folders of
/// one name and several numbers do not have nine tenths of the names of images in common, and where
/// these are numbers, as those of photos are.
std::vector<ImageSequence> sequences_of_timesteps(const std::filesystem::path& capture);

}  // namespace tessera
