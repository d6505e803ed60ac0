// The noise of images, from their flattest parts. Source: [Immerkaer96], of the local standard
// deviation: an image has tiles in which there is little beside noise, so the lowest tenth of its
// tiles tells noise from texture.
#pragma once
#include "ingest/scene.h"

namespace tessera {

/// Standard deviation of the noise of an image's green channel, 8-bit levels. Tiles that are nearly
/// black or white, or in whose middle `mask` ignores the pixel, do not count. 0 where an image has
/// too few tiles.
double image_noise(const Image8& image, const FrameMask& mask = {});

/// Median over the training cameras, each by its first frame that has pixels; 0 where there is
/// none.
double image_noise(const Scene& scene);

}  // namespace tessera
