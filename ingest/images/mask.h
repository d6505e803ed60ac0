// What: an image of a mask → which pixels are used. The one place of the polarity: values of 127
//       and less are ignored, as black is by Nerfstudio and COLMAP; larger ones are used.
// Not: files (scene_reader.h, ingest/layouts/mask_source.h), and no soft weights between the
// two.
#pragma once
#include <filesystem>

#include "ingest/scene.h"

namespace tessera {

/// One channel of 0 (ignored) and 255 (used). The value of a pixel is its alpha, where that says
/// anything, else its brightest channel. Errors: InputError naming `file`: all values are small but
/// not all zero, as in masks of 0 and 1.
Image8 mask_of_image(const Image8& image, const std::filesystem::path& file);

/// Errors: InputError naming `file` when the mask does not have the size of its image.
void check_mask_size(const Image8& mask, int width, int height, const std::filesystem::path& file);

/// Exchanges used and ignored.
void invert_mask(Image8& mask);

}  // namespace tessera
