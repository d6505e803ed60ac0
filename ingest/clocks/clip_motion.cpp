// Differences of frames, SIFT features where these are large, and optical flow to the neighbouring
// frames. Sources: Lowe 2004 (SIFT); Lucas, Kanade 1981 and Bouguet 2000 (optical flow).
#include "ingest/clocks/clip_motion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "ingest/images/alpha_and_mask.h"
#include "ingest/video/clip_frames.h"

namespace tessera {
namespace {

constexpr int kEnergySide = 240;  // pixels of the longer side in which change is looked for

/// Levels by which two frames differ beyond what noise does, CV_32F.
cv::Mat change(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kFlicker = 3;  // levels, of compression
  cv::Mat difference, smooth_a, smooth_b;
  cv::GaussianBlur(a, smooth_a, {5, 5}, 1.2);
  cv::GaussianBlur(b, smooth_b, {5, 5}, 1.2);
  cv::absdiff(smooth_a, smooth_b, difference);
  difference.convertTo(difference, CV_32F);
  const double noise = cv::mean(cv::min(difference, 8))[0];  // movers, large, hardly raise it
  return cv::max(difference - (kFlicker + 2 * noise), 0);
}

/// Where something changes between the frame and its neighbours, CV_8U.
cv::Mat moving_mask(const cv::Mat& before, const cv::Mat& now, const cv::Mat& after) {
  cv::Mat mask = (change(before, now) > 0) | (change(now, after) > 0);
  cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}));
  return mask;
}

/// The mask's bounds, with the margin that SIFT uses.
cv::Rect neighbourhood(const cv::Mat& mask) {
  constexpr int kMargin = 32;  // pixels
  const cv::Rect moving = cv::boundingRect(mask);
  if (moving.empty()) return {};
  const cv::Rect wide(moving.x - kMargin, moving.y - kMargin, moving.width + 2 * kMargin,
                      moving.height + 2 * kMargin);
  return wide & cv::Rect(0, 0, mask.cols, mask.rows);
}

const cv::Size kWindow(15, 15);  // pixels that optical flow compares
constexpr int kLevels = 3;       // above the image itself in its pyramid

using Pyramid = std::vector<cv::Mat>;

Pyramid pyramid_of(const cv::Mat& image) {
  Pyramid pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, kWindow, kLevels);
  return pyramid;
}

/// Where the points are in the other frame; false in `found` where tracking back does not return.
std::vector<cv::Point2f> follow(const Pyramid& from, const Pyramid& to,
                                const std::vector<cv::Point2f>& points, std::vector<bool>& found) {
  constexpr double kReturn = 0.3;  // pixels
  std::vector<cv::Point2f> moved, back;
  std::vector<uint8_t> good, good_back;
  const cv::TermCriteria end(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.003);
  cv::calcOpticalFlowPyrLK(from, to, points, moved, good, cv::noArray(), kWindow, kLevels, end);
  cv::calcOpticalFlowPyrLK(to, from, moved, back, good_back, cv::noArray(), kWindow, kLevels, end);
  for (size_t i = 0; i < points.size(); ++i)
    found[i] = found[i] && good[i] && good_back[i] && cv::norm(back[i] - points[i]) < kReturn;
  return moved;
}

}  // namespace

GreyClip::GreyClip(const RigClip& clip, size_t bound)
    : clip_(clip), kept_(clip.timeline.ticks.size()) {
  const VideoTimeline& timeline = clip.timeline;
  const double scale = std::min(1.0, double(kGreySide) / std::max(timeline.width, timeline.height));
  size_ = {std::max(1, int(std::lround(scale * timeline.width))),
           std::max(1, int(std::lround(scale * timeline.height)))};
  room_ = bound / size_t(size_.area());
}

void GreyClip::read(const std::vector<size_t>& frames,
                    const std::function<void(size_t frame, const cv::Mat& image)>& on_image) {
  auto next = frames.begin();
  const auto hand_over_kept = [&] {
    for (; next != frames.end() && !kept_[*next].empty(); ++next) on_image(*next, kept_[*next]);
  };
  std::vector<int64_t> wanted;
  for (const size_t frame : frames)
    if (kept_[frame].empty()) wanted.push_back(clip_.timeline.ticks[frame]);
  hand_over_kept();
  const auto on_frame = [&](const VideoFrame& frame) {
    const Image8 opaque = composite_on(frame.image, {0, 0, 0});
    const cv::Mat rgb(size_, CV_8UC3, const_cast<uint8_t*>(opaque.data.data()));
    cv::Mat grey;
    cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
    if (room_ > 0) {
      kept_[*next] = grey;
      --room_;
    }
    on_image(*next++, grey);
    hand_over_kept();
    return true;
  };
  decode_clip(clip_, wanted, on_frame, {Truncation::kKeepWhatIsThere, size_.width, size_.height});
}

MotionEnergy motion_energy(GreyClip& clip) {
  MotionEnergy energy;
  const VideoTimeline& timeline = clip.timeline();
  energy.width = timeline.width;
  energy.height = timeline.height;
  const double longest = std::max(timeline.width, timeline.height), cell = longest / kMotionCells;
  const cv::Size grid(std::max(1, int(std::lround(timeline.width / cell))),
                      std::max(1, int(std::lround(timeline.height / cell))));
  cv::Mat last, now;
  std::vector<size_t> frames(std::min(timeline.ticks.size(), size_t(kMotionFrames)));
  std::iota(frames.begin(), frames.end(), size_t{0});
  clip.read(frames, [&](size_t frame, const cv::Mat& image) {
    const double scale = double(kEnergySide) / std::max(image.cols, image.rows);
    if (scale < 1)
      cv::resize(image, now, {}, scale, scale, cv::INTER_AREA);
    else
      now = image.clone();
    if (frame > 0) {
      cv::Mat cells;
      cv::resize(change(last, now), cells, grid, 0, 0, cv::INTER_AREA);
      energy.seconds.push_back(0.5 * (timeline.seconds(frame - 1) + timeline.seconds(frame)));
      energy.cells.push_back(cells);
    }
    cv::swap(last, now);
  });
  return energy;
}

std::vector<FrameTriple> frames_in(GreyClip& clip, const std::vector<Stretch>& stretches) {
  const VideoTimeline& timeline = clip.timeline();
  std::vector<size_t> middles, needed;
  for (const Stretch& stretch : stretches)
    for (size_t i = 1; i + 1 < timeline.ticks.size(); ++i)
      if (timeline.seconds(i) >= stretch.begin && timeline.seconds(i) <= stretch.end &&
          (middles.empty() || i > middles.back()))
        middles.push_back(i);
  for (const size_t i : middles)
    for (size_t k = i - 1; k <= i + 1; ++k)
      if (needed.empty() || k > needed.back()) needed.push_back(k);
  std::map<size_t, cv::Mat> images;
  clip.read(needed, [&](size_t frame, const cv::Mat& image) { images[frame] = image; });
  std::vector<FrameTriple> all;
  for (const size_t i : middles) {
    FrameTriple frame;
    frame.enlarge = std::max(1.0, double(std::max(timeline.width, timeline.height)) / kGreySide);
    for (size_t k = 0; k < 3; ++k) {
      frame.seconds[k] = timeline.seconds(i - 1 + k);
      frame.image[k] = images[i - 1 + k];
    }
    if (!frame.image[0].empty() && !frame.image[1].empty() && !frame.image[2].empty())
      all.push_back(std::move(frame));  // a truncated clip ends early
  }
  return all;
}

MovingFeatures moving_features(const FrameTriple& frame) {
  const auto& [before, now, after] = frame.image;
  MovingFeatures features{frame.seconds[1], frame.seconds[0], frame.seconds[2], {}, {}, {}, {}};
  const cv::Mat mask = moving_mask(before, now, after);
  const cv::Rect part = neighbourhood(mask);
  if (part.empty()) return features;
  const auto sift = cv::SIFT::create(kFeatures, 3, 0.03);
  std::vector<cv::KeyPoint> keys;
  cv::Mat descriptor;
  sift->detectAndCompute(now(part), mask(part), keys, descriptor);
  if (keys.empty()) return features;
  std::vector<cv::Point2f> points;
  for (const cv::KeyPoint& key : keys) points.push_back(key.pt + cv::Point2f(part.tl()));
  std::vector<bool> found(points.size(), true);
  const Pyramid here = pyramid_of(now);
  const auto past = follow(here, pyramid_of(before), points, found);
  const auto future = follow(here, pyramid_of(after), points, found);
  const auto in_video = [&](const cv::Point2f& p) {  // OpenCV's (0, 0) is a pixel's centre
    return cv::Point2d((p.x + 0.5) * frame.enlarge, (p.y + 0.5) * frame.enlarge);
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

}  // namespace tessera
