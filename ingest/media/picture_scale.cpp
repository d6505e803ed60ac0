// What: OpenCV's INTER_AREA in float on premultiplied colours.
// Not: linear light: values are averaged as encoded, as the field's own down-scaling does.
#include "ingest/media/picture_scale.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Multiplies (or divides, `inverse`) the colours of RGBA pixels by alpha, in [0, 255] floats.
void weight_by_alpha(cv::Mat& pixels, bool inverse) {
  for (int y = 0; y < pixels.rows; ++y)
    for (int x = 0; x < pixels.cols; ++x) {
      auto& pixel = pixels.at<cv::Vec4f>(y, x);
      const float alpha = pixel[3] / 255.0f;
      const float factor = !inverse ? alpha : alpha > 0 ? 1 / alpha : 0.0f;
      for (int c = 0; c < 3; ++c) pixel[c] *= factor;
    }
}

}  // namespace

int scaled_side(int side, double scale) {
  return std::max(1, int(std::lround(side * scale)));
}

Image8 scale_picture(const Image8& picture, int width, int height) {
  check(width > 0 && height > 0 && width <= picture.width && height <= picture.height,
        "scale_picture size");
  if (width == picture.width && height == picture.height) return picture;
  const cv::Mat source(picture.height, picture.width, CV_8UC(picture.channels),
                       const_cast<uint8_t*>(picture.data.data()));
  cv::Mat pixels, scaled;
  source.convertTo(pixels, CV_32F);
  if (picture.channels == 4) weight_by_alpha(pixels, false);
  cv::resize(pixels, scaled, {width, height}, 0, 0, cv::INTER_AREA);
  if (picture.channels == 4) weight_by_alpha(scaled, true);
  Image8 result{width, height, picture.channels, {}};
  result.data.resize(size_t(width) * size_t(height) * size_t(picture.channels));
  cv::Mat target(height, width, CV_8UC(picture.channels), result.data.data());
  scaled.convertTo(target, CV_8U);  // rounds and saturates
  return result;
}

}  // namespace tessera
