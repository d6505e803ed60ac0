// Computes medians over time. A pixel is moving where its deviation from the median exceeds the
// noise of the image.
#include "ingest/colmap/rig_background.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "ingest/images/alpha_and_mask.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int kBlur = 5;             // pixels, box: noise averages out, motion does not
constexpr float kLeastMotion = 8;    // 8-bit values: coded noise flickers in blocks of less
constexpr float kNoiseFactor = 4;    // motion deviates by this many times the median deviation
constexpr double kSteady = 0.5;      // of the frames must show what the median shows
constexpr double kReach = 1.0 / 60;  // of the image's width: features extend beyond their centre

/// max(0, 2|mean d| − mean|d|) of the differences d from the median over time, means over
/// neighbours: |d| where all differ alike, as where something moves; 0 of noise, however strong.
cv::Mat deviation_of(const Image8& image, const Image8& median) {
  cv::Mat difference(median.height, median.width, CV_32F, cv::Scalar(0)), mean, magnitude;
  const float share = 1.0f / float(median.channels);
  for (size_t scalar = 0; scalar < median.data.size(); ++scalar)
    reinterpret_cast<float*>(difference.data)[scalar / size_t(median.channels)] +=
        share * float(int(image.data[scalar]) - int(median.data[scalar]));
  cv::blur(difference, mean, cv::Size(kBlur, kBlur));
  cv::blur(cv::abs(difference), magnitude, cv::Size(kBlur, kBlur));
  return cv::max(2 * cv::abs(mean) - magnitude, 0.0);
}

/// At each pixel the deviation that a share kSteady of the images does not exceed: what passes
/// by in a few of them leaves the median as it is.
cv::Mat steady_deviation(const std::vector<Image8>& images, const Image8& median) {
  std::vector<cv::Mat> deviations;
  for (const Image8& image : images) deviations.push_back(deviation_of(image, median));
  const auto rank = size_t(kSteady * double(images.size() - 1));
  cv::Mat steady(median.height, median.width, CV_32F);
  std::vector<float> values(images.size());
  for (int y = 0; y < steady.rows; ++y)
    for (int x = 0; x < steady.cols; ++x) {
      for (size_t k = 0; k < values.size(); ++k) values[k] = deviations[k].at<float>(y, x);
      std::nth_element(values.begin(), values.begin() + ptrdiff_t(rank), values.end());
      steady.at<float>(y, x) = values[rank];
    }
  return steady;
}

float median_of(const cv::Mat& values) {
  std::vector<float> sorted(values.begin<float>(), values.end<float>());
  return median_in_place(sorted);
}

cv::Mat widened(const cv::Mat& moving) {
  const int reach = std::max(3, int(kReach * moving.cols));
  cv::Mat wide;
  cv::dilate(moving, wide,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * reach + 1, 2 * reach + 1)));
  return wide;
}

Image8 image_of(const cv::Mat& mask) {
  return {mask.cols, mask.rows, 1, {mask.begin<uint8_t>(), mask.end<uint8_t>()}};
}

}  // namespace

std::vector<size_t> spread_frames(size_t frames, size_t count) {
  count = std::min(count, frames);
  std::vector<size_t> chosen;
  for (size_t i = 0; i < count; ++i)
    chosen.push_back(size_t(even_spread(int64_t(i), int64_t(count), int64_t(frames))));
  return chosen;
}

std::vector<Image8> sample_images(const RigClip& clip, const std::vector<size_t>& chosen) {
  std::vector<int64_t> wanted;
  for (const size_t frame : chosen) wanted.push_back(clip.timeline.ticks.at(frame));
  std::vector<Image8> images;
  decode_clip(clip, wanted, [&](VideoFrame decoded) {
    images.push_back(composite_on(decoded.image, {0, 0, 0}));
    return true;
  });
  check(images.size() == chosen.size(), "the timeline has more frames than the video");
  return images;
}

StillImage still_image(const std::vector<Image8>& images) {
  StillImage still{images.front(), {}};
  Image8& median = still.image;
  parallel_for(int64_t(median.data.size()), 1 << 14, [&](int64_t begin, int64_t end) {
    std::vector<uint8_t> values(images.size());
    for (auto scalar = size_t(begin); scalar < size_t(end); ++scalar) {
      for (size_t k = 0; k < images.size(); ++k) values[k] = images[k].data[scalar];
      median.data[scalar] = median_in_place(values);
    }
  });
  const cv::Mat deviation = steady_deviation(images, median);
  still.threshold = std::max(kLeastMotion, kNoiseFactor * median_of(deviation));
  still.mask = image_of(255 - widened(deviation > still.threshold));
  return still;
}

Image8 moving_mask(const Image8& image, const StillImage& still) {
  const cv::Mat deviation = deviation_of(image, still.image);
  return image_of(widened(deviation > still.threshold));
}

}  // namespace tessera
