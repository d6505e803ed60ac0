// What: what moves in a clip: where and how much between frames, and moving features with their
//       paths; gathered from small grey images.
// Not: comparisons of clips (motion_profile.h, motion_matches.h).
#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "ingest/clocks/grey_clip.h"

namespace tessera {

/// Change from one frame to the next, on a grid of kMotionCells along the longer side.
struct MotionEnergy {
  std::vector<double> seconds;  // [M] midway between the two frames, increasing
  std::vector<cv::Mat> cells;   // [M] CV_32F, levels beyond the noise
  int width = 0, height = 0;    // of the video, pixels
};

/// Of the first kMotionFrames frames. Memory: 48 × 48 × 4 B a frame, 17 MB at most.
constexpr int kMotionCells = 48, kMotionFrames = 1800;
MotionEnergy motion_energy(GreyClip& clip);

/// Features of one frame that lie where something moves, with where they are a frame before and
/// after. Points are in pixels of the video, (0, 0) the image's corner.
struct MovingFeatures {
  double seconds = 0, before_seconds = 0, after_seconds = 0;
  std::vector<cv::Point2d> point, before, after;  // [K]
  cv::Mat descriptor;                             // [K, 128] CV_32F, unit length
};

/// Of the frames from `begin` to `end`, seconds; at most kFeatures a frame. Memory: 90 kB a
/// frame, and what the clip keeps.
constexpr int kFeatures = 160;
std::vector<MovingFeatures> moving_features(GreyClip& clip, double begin, double end);

}  // namespace tessera
