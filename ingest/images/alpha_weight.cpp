// What: the two loops over RGBA pixels around every resampling.
// Not: compositing (alpha_composite.h): alpha is kept.
#include "ingest/images/alpha_weight.h"

#include <opencv2/core.hpp>

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

cv::Mat alpha_weighted(const Image8& image) {
  const cv::Mat source(image.height, image.width, CV_8UC(image.channels),
                       const_cast<uint8_t*>(image.data.data()));
  cv::Mat pixels;
  source.convertTo(pixels, CV_32F);
  if (image.channels == 4) weight_by_alpha(pixels, false);
  return pixels;
}

Image8 without_alpha_weight(cv::Mat& pixels) {
  const int channels = pixels.channels();
  if (channels == 4) weight_by_alpha(pixels, true);
  Image8 result{pixels.cols, pixels.rows, channels, {}};
  result.data.resize(size_t(pixels.cols) * size_t(pixels.rows) * size_t(channels));
  cv::Mat target(pixels.rows, pixels.cols, CV_8UC(channels), result.data.data());
  pixels.convertTo(target, CV_8U);  // rounds and saturates
  return result;
}

}  // namespace tessera
