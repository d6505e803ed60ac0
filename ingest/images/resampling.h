// Resamples images: area averages of a smaller size, and the image of a pinhole camera from an
// image with lens distortion. Colours are weighted by alpha.
#pragma once
#include <opencv2/core/mat.hpp>

#include "ingest/poses/lens.h"
#include "ingest/scene.h"

namespace tessera {

/// Errors: none; a size of zero, or one that is larger than the image, is a bug of the caller.
Image8 scale_image(const Image8& image, int width, int height);

/// The size of a side scaled by `scale`, at least one pixel.
int scaled_side(int side, double scale);

/// Computed once for a camera, then applied to each of its images, also by several threads.
class Undistortion {
 public:
  /// Images are taken by `camera` through `lens`; results have the size of `pinhole`, whose pose
  /// is the same.
  Undistortion(const Camera& camera, const Lens& lens, const Camera& pinhole);
  /// Bilinear; with alpha, colours are weighted by it; beyond the border it repeats, also where the
  /// lens shows the ray of a pixel nowhere. An image of another size than the camera's is a bug of
  /// the caller.
  Image8 apply(const Image8& image) const;

 private:
  int width_, height_;  // of the camera
  cv::Mat place_;       // [height, width] of the pinhole image: where in the camera's, pixels
};

}  // namespace tessera
