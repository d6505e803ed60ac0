// Alpha and masks. An image with alpha is composited once on a background colour, as in the D-NeRF
// protocol. Mask values up to 127 are ignored, as black is in Nerfstudio and COLMAP; larger values
// are used. Where values are objects, only black is ignored.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>

#include "ingest/scene.h"

namespace tessera {

/// RGB of `image` (1, 3 or 4 channels): round(bg·(1 − a) + rgb·a) in float from 8 bit, where rgb is
/// as stored (not premultiplied); grey is repeated, RGB passes through.
Image8 composite_on(const Image8& image, const std::array<uint8_t, 3>& background);

/// Whether the pixels are numbers or colours of objects, as programs of segmentation write them,
/// opaque: the largest value is 1 to 31, or channels differ by 32 and more.
bool has_object_numbers(const Image8& image);

/// One channel of 0 (ignored) and 255 (used). The value of a pixel is its alpha where the
/// image has transparent pixels, else its brightest channel. Of object numbers all but 0 is used,
/// of object colours what is brighter than 31. Errors: InputError naming `file`: the largest value
/// is 32 to 127 of others.
Image8 mask_of_image(const Image8& image, const std::filesystem::path& file);

/// Errors: InputError naming `file` when the mask does not have the size of its image.
void check_mask_size(const Image8& mask, int width, int height, const std::filesystem::path& file);

/// Exchanges used and ignored.
void invert_mask(Image8& mask);

}  // namespace tessera
