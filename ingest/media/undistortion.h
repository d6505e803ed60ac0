// What: the picture that a pinhole camera would have taken, resampled from one through a lens.
// Not: the choice of that camera (lens.h).
#pragma once
#include "ingest/lens.h"
#include "ingest/scene.h"

namespace tessera {

/// `picture` was taken by `camera` through `lens`; the result has the size of `pinhole`, whose pose
/// is the same. Bilinear; with alpha, colours are weighted by it; beyond the border it repeats.
Image8 undistorted_picture(const Image8& picture, const Camera& camera, const Lens& lens,
                           const Camera& pinhole);

}  // namespace tessera
