// Uses INTER_AREA and remap of OpenCV in float with premultiplied colours. Values are averaged as
// encoded. The maps come from Lens, because OpenCV lacks some models of COLMAP and has pixel
// centres at integers.
#include "ingest/images/resampling.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "ingest/poses/pinhole_view.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kBeyond = 1e4;  // a place outside of any image, in focal lengths

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

/// Floats of [0, 255]; RGBA colours are multiplied by alpha / 255, others as they are.
cv::Mat alpha_weighted(const Image8& image) {
  const cv::Mat source(image.height, image.width, CV_8UC(image.channels),
                       const_cast<uint8_t*>(image.data.data()));
  cv::Mat pixels;
  source.convertTo(pixels, CV_32F);
  if (image.channels == 4) weight_by_alpha(pixels, false);
  return pixels;
}

/// The inverse, rounded and saturated; colours without alpha are black. Divides in place.
Image8 without_alpha_weight(cv::Mat& pixels) {
  const int channels = pixels.channels();
  if (channels == 4) weight_by_alpha(pixels, true);
  Image8 result{pixels.cols, pixels.rows, channels, {}};
  result.data.resize(size_t(pixels.cols) * size_t(pixels.rows) * size_t(channels));
  cv::Mat target(pixels.rows, pixels.cols, CV_8UC(channels), result.data.data());
  pixels.convertTo(target, CV_8U);  // rounds and saturates
  return result;
}

}  // namespace

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

Undistortion::Undistortion(const Camera& camera, const Lens& lens, const Camera& pinhole)
    : width_(camera.width),
      height_(camera.height),
      place_(pinhole.height, pinhole.width, CV_32FC2) {
  const double reach = lens.outward_reach(shortest_ray(camera), kFarthestRay);
  for (int y = 0; y < pinhole.height; ++y)
    for (int x = 0; x < pinhole.width; ++x) {
      const glm::dvec2 ray((x + 0.5 - pinhole.cx) / pinhole.fl_x,
                           (y + 0.5 - pinhole.cy) / pinhole.fl_y);
      // rays beyond are shown by no pixel: the place of the border, which masks ignore
      const glm::dvec2 met = glm::length(ray) <= reach ? lens.distorted(ray) : glm::dvec2(-kBeyond);
      place_.at<cv::Vec2f>(y, x) = {float(camera.fl_x * met.x + camera.cx - 0.5),
                                    float(camera.fl_y * met.y + camera.cy - 0.5)};
    }
}

Image8 Undistortion::apply(const Image8& image) const {
  check(image.width == width_ && image.height == height_, "undistorted image size");
  cv::Mat pixels;
  cv::remap(alpha_weighted(image), pixels, place_, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return without_alpha_weight(pixels);
}

}  // namespace tessera
