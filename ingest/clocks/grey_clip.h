// What: a clip's frames as small grey images, decoded once where memory allows.
// Not: colour, or what moves in them (clip_motion.h).
#pragma once
#include <cstddef>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "ingest/video/rig_clip.h"

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

}  // namespace tessera
