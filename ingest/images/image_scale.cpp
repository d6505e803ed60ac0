// What: OpenCV's INTER_AREA in float on premultiplied colours.
// Not: linear light: values are averaged as encoded, as the field's own down-scaling does.
#include "ingest/images/image_scale.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ingest/images/alpha_weight.h"
#include "kernels/base/errors.h"

namespace tessera {

int scaled_side(int side, double scale) {
  return std::max(1, int(std::lround(side * scale)));
}

Image8 scale_image(const Image8& image, int width, int height) {
  check(width > 0 && height > 0 && width <= image.width && height <= image.height,
        "scale_picture size");
  if (width == image.width && height == image.height) return image;
  cv::Mat scaled;
  cv::resize(alpha_weighted(image), scaled, {width, height}, 0, 0, cv::INTER_AREA);
  return without_alpha_weight(scaled);
}

}  // namespace tessera
