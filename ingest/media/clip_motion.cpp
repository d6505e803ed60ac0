// What: differences of frames, SIFT where they are large, and optical flow to the next frames.
// Not: a background model: neighbours in time are enough to say what moves now.
// Source: Lowe 2004 (SIFT); Lucas, Kanade 1981, Bouguet 2000 (optical flow).
#include "ingest/media/clip_motion.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "ingest/media/video_decoder.h"

namespace tessera {
namespace {

constexpr int kEnergySide = 240, kFeatureSide = 480;  // pixels of the longer side

cv::Mat small_grey(const Image8& image, int longest) {
  const cv::Mat rgb(image.height, image.width, CV_8UC3, const_cast<uint8_t*>(image.data.data()));
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  const double scale = double(longest) / std::max(image.width, image.height);
  if (scale < 1) cv::resize(grey, grey, {}, scale, scale, cv::INTER_AREA);
  return grey;
}

/// Levels by which two frames differ beyond what noise does, CV_32F.
cv::Mat change(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kLevels = 3;  // compression's own flicker
  cv::Mat difference, smooth_a, smooth_b;
  cv::GaussianBlur(a, smooth_a, {5, 5}, 1.2);
  cv::GaussianBlur(b, smooth_b, {5, 5}, 1.2);
  cv::absdiff(smooth_a, smooth_b, difference);
  difference.convertTo(difference, CV_32F);
  const double noise = cv::mean(cv::min(difference, 8))[0];  // movers, large, hardly raise it
  return cv::max(difference - (kLevels + 2 * noise), 0);
}

/// Where something changes between the frame and its neighbours, CV_8U.
cv::Mat moving_mask(const cv::Mat& before, const cv::Mat& now, const cv::Mat& after) {
  cv::Mat mask = (change(before, now) > 0) | (change(now, after) > 0);
  cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}));
  return mask;
}

struct TimedPicture {
  double seconds = 0;
  cv::Mat picture;
};

/// Where the points are in the other frame; false in `found` where the way back does not return.
std::vector<cv::Point2f> follow(const cv::Mat& from, const cv::Mat& to,
                                const std::vector<cv::Point2f>& points, std::vector<bool>& found) {
  constexpr double kReturn = 0.3;  // pixels
  std::vector<cv::Point2f> there, back;
  std::vector<uint8_t> good, good_back;
  const cv::Size window(15, 15);
  const cv::TermCriteria end(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.003);
  cv::calcOpticalFlowPyrLK(from, to, points, there, good, cv::noArray(), window, 3, end);
  cv::calcOpticalFlowPyrLK(to, from, there, back, good_back, cv::noArray(), window, 3, end);
  for (size_t i = 0; i < points.size(); ++i)
    found[i] = found[i] && good[i] && good_back[i] && cv::norm(back[i] - points[i]) < kReturn;
  return there;
}

MovingFeatures features_of(const TimedPicture& before, const TimedPicture& now,
                           const TimedPicture& after, double enlarge) {
  MovingFeatures features{now.seconds, before.seconds, after.seconds, {}, {}, {}, {}};
  const auto sift = cv::SIFT::create(kFeatures, 3, 0.03);
  std::vector<cv::KeyPoint> keys;
  cv::Mat descriptor;
  sift->detectAndCompute(now.picture, moving_mask(before.picture, now.picture, after.picture), keys,
                         descriptor);
  if (keys.empty()) return features;
  std::vector<cv::Point2f> points;
  cv::KeyPoint::convert(keys, points);
  std::vector<bool> found(points.size(), true);
  const auto past = follow(now.picture, before.picture, points, found);
  const auto future = follow(now.picture, after.picture, points, found);
  const auto in_video = [&](const cv::Point2f& p) {  // OpenCV's (0, 0) is a pixel's centre
    return cv::Point2d((p.x + 0.5) * enlarge, (p.y + 0.5) * enlarge);
  };
  for (size_t i = 0; i < points.size(); ++i) {
    if (!found[i]) continue;
    features.point.push_back(in_video(points[i]));
    features.before.push_back(in_video(past[i]));
    features.after.push_back(in_video(future[i]));
    cv::Mat row = descriptor.row(int(i)).clone();
    features.descriptor.push_back(cv::Mat(row / std::max(1e-6, cv::norm(row))));
  }
  return features;
}

}  // namespace

void read_grey_pictures(const std::filesystem::path& video, int longest,
                        const OnGreyPicture& on_picture) {
  const Rational time_base = probe_video(video).time_base;
  decode_video(video, [&](const VideoFrame& frame) {
    return on_picture(time_base.at(frame.ticks), small_grey(frame.image, longest));
  });
}

MotionEnergy motion_energy(const std::filesystem::path& video) {
  MotionEnergy energy;
  const VideoStream stream = probe_video(video);
  energy.width = stream.width, energy.height = stream.height;
  const double cell = double(std::max(stream.width, stream.height)) / kMotionCells;
  const cv::Size grid(std::max(1, int(std::lround(stream.width / cell))),
                      std::max(1, int(std::lround(stream.height / cell))));
  TimedPicture last;
  read_grey_pictures(video, kEnergySide, [&](double seconds, const cv::Mat& picture) {
    if (!last.picture.empty()) {
      cv::Mat cells;
      cv::resize(change(last.picture, picture), cells, grid, 0, 0, cv::INTER_AREA);
      energy.seconds.push_back(0.5 * (last.seconds + seconds));
      energy.cells.push_back(cells);
    }
    last = {seconds, picture};
    return energy.cells.size() < size_t(kMotionFrames);
  });
  return energy;
}

std::vector<MovingFeatures> moving_features(const std::filesystem::path& video, double begin,
                                            double end) {
  std::vector<MovingFeatures> all;
  const VideoStream stream = probe_video(video);
  const double enlarge =
      std::max(1.0, double(std::max(stream.width, stream.height)) / kFeatureSide);
  std::deque<TimedPicture> window;
  read_grey_pictures(video, kFeatureSide, [&](double seconds, const cv::Mat& picture) {
    window.push_back({seconds, picture});
    if (window.size() < 3) return true;
    if (window.size() > 3) window.pop_front();
    if (window[1].seconds > end) return false;
    if (window[1].seconds >= begin)
      all.push_back(features_of(window[0], window[1], window[2], enlarge));
    return true;
  });
  return all;
}

}  // namespace tessera
