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
  /// Calls `on_image` with these frames, which ascend, in one pass. Only those that are not kept
  /// are decoded. Errors: those of decode_clip.
  void read(const std::vector<size_t>& frames,
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
  cv::Mat descriptor;                             // [K, kDescriptor] CV_32F, unit length
};
constexpr int kDescriptor = 128;

/// Seconds.
struct Stretch {
  double begin = 0, end = 0;
};

/// A frame of a clip, and the small images of it and its neighbours.
struct FrameTriple {
  double seconds[3] = {};  // before, of the frame, after
  cv::Mat image[3];
  double enlarge = 1;  // pixels of the video a pixel of these
};

/// The frames of these stretches of the clip's time, which ascend.
std::vector<FrameTriple> frames_in(GreyClip& clip, const std::vector<Stretch>& stretches);

/// At most kFeatures: 0.2 MB. SIFT at twice the size of the images takes the time, few features or
/// many.
constexpr int kFeatures = 400;
MovingFeatures moving_features(const FrameTriple& frame);

}  // namespace tessera
