// Motion in a clip, measured on small grey images: the energy and position of changes between
// frames, and the paths of moving features. Images are decoded once where memory allows.
#pragma once
#include <cstddef>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "ingest/video/clip_frames.h"

namespace tessera {

/// The longer side of the images is at most kGreySide pixels. Memory: at most `bound` bytes of
/// images, those that were read first, and one more.
class GreyClip {
 public:
  GreyClip(const RigClip& clip, size_t bound);

  const VideoTimeline& timeline() const { return clip_.timeline; }
  /// Calls `on_image` with the frames from `first` to before `last`, in order. Only those that
  /// are not kept are decoded. Errors: those of decode_clip.
  void read(size_t first, size_t last,
            const std::function<void(size_t frame, const cv::Mat& image)>& on_image);

 private:
  const RigClip& clip_;
  cv::Size size_;
  size_t room_ = 0;            // images that may still be kept
  std::vector<cv::Mat> kept_;  // CV_8U by frame; empty: not kept
};

constexpr int kGreySide = 480;

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
