// What: OpenCV's INTER_AREA in float on premultiplied colours.
// Not: linear light: values are averaged as encoded, as the field's own down-scaling does.
#include "ingest/media/images/picture_scale.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ingest/media/images/alpha_weight.h"
#include "kernels/base/errors.h"

namespace tessera {

int scaled_side(int side, double scale) {
  return std::max(1, int(std::lround(side * scale)));
}

Image8 scale_picture(const Image8& picture, int width, int height) {
  check(width > 0 && height > 0 && width <= picture.width && height <= picture.height,
        "scale_picture size");
  if (width == picture.width && height == picture.height) return picture;
  cv::Mat scaled;
  cv::resize(alpha_weighted(picture), scaled, {width, height}, 0, 0, cv::INTER_AREA);
  return without_alpha_weight(scaled);
}

}  // namespace tessera
