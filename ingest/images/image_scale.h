// What: area down-scaling of images; with alpha, colours are weighted by it.
// Not: enlarging, and no other filter: area averages are what a larger pixel would have measured.
#pragma once
#include "ingest/scene.h"

namespace tessera {

/// Errors: none; a size of zero, or one that is larger than the image, is a bug of the caller.
Image8 scale_image(const Image8& image, int width, int height);

/// The size of a side scaled by `scale`, at least one pixel.
int scaled_side(int side, double scale);

}  // namespace tessera
