// What: an image with alpha over a background colour, once, as the D-NeRF protocol does it.
// Not: resizing of images with alpha (ingest/images/image_scale.h).
#pragma once
#include <array>
#include <cstdint>

#include "ingest/scene.h"

namespace tessera {

/// RGB of `image` (1, 3 or 4 channels): round(bg·(1 − a) + rgb·a) in float from 8 bit, where rgb is
/// as stored (not premultiplied); grey is repeated, RGB passes through.
Image8 composite_on(const Image8& image, const std::array<uint8_t, 3>& background);

}  // namespace tessera
