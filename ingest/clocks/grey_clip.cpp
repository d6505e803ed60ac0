// What: decoding at the reduced size, and which images stay.
// Not: the decoder (video_decoder.h).
#include "ingest/clocks/grey_clip.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ingest/images/alpha_composite.h"
#include "ingest/video/clip_frames.h"

namespace tessera {

GreyClip::GreyClip(const RigClip& clip, size_t bound)
    : clip_(clip), kept_(clip.timeline.ticks.size()) {
  const VideoTimeline& timeline = clip.timeline;
  const double scale = std::min(1.0, double(kGreySide) / std::max(timeline.width, timeline.height));
  size_ = {std::max(1, int(std::lround(scale * timeline.width))),
           std::max(1, int(std::lround(scale * timeline.height)))};
  room_ = bound / size_t(size_.area());
}

void GreyClip::read(size_t first, size_t last,
                    const std::function<void(size_t frame, const cv::Mat& image)>& on_image) {
  size_t next = first;
  const auto hand_over_kept = [&] {
    for (; next < last && !kept_[next].empty(); ++next) on_image(next, kept_[next]);
  };
  std::vector<int64_t> wanted;
  for (size_t frame = first; frame < last; ++frame)
    if (kept_[frame].empty()) wanted.push_back(clip_.timeline.ticks[frame]);
  hand_over_kept();
  const auto on_frame = [&](const VideoFrame& frame) {
    const Image8 opaque = composite_on(frame.image, {0, 0, 0});
    const cv::Mat rgb(size_, CV_8UC3, const_cast<uint8_t*>(opaque.data.data()));
    cv::Mat grey;
    cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
    if (room_ > 0) {
      kept_[next] = grey;
      --room_;
    }
    on_image(next++, grey);
    hand_over_kept();
    return true;
  };
  decode_clip(clip_, wanted, on_frame, {Truncation::kKeepWhatIsThere, size_.width, size_.height});
}

}  // namespace tessera
