// What: for each pixel of the pinhole camera the place in the image, then OpenCV's remap.
// Not: OpenCV's own lens models: it has not all of COLMAP's, and its pixel centres are at integers.
#include "ingest/images/undistortion.h"

#include <opencv2/imgproc.hpp>

#include "ingest/images/alpha_weight.h"
#include "kernels/base/errors.h"

namespace tessera {

Undistortion::Undistortion(const Camera& camera, const Lens& lens, const Camera& pinhole)
    : width_(camera.width),
      height_(camera.height),
      place_(pinhole.height, pinhole.width, CV_32FC2) {
  for (int y = 0; y < pinhole.height; ++y)
    for (int x = 0; x < pinhole.width; ++x) {
      const glm::dvec2 met = lens.distorted(
          {(x + 0.5 - pinhole.cx) / pinhole.fl_x, (y + 0.5 - pinhole.cy) / pinhole.fl_y});
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
