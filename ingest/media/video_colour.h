// What: a decoded frame of any pixel format → 8-bit RGB, with the right matrix and range.
// Not: a colour space conversion: primaries and transfer stay those of the video.
#pragma once
#include "ingest/scene.h"

struct AVFrame;
struct SwsContext;

namespace tessera {

class FrameToRgb {
 public:
  FrameToRgb();
  ~FrameToRgb();
  FrameToRgb(const FrameToRgb&) = delete;
  FrameToRgb& operator=(const FrameToRgb&) = delete;

  /// Unstated matrices are BT.601 below 720 lines, BT.709 from there. An empty image where the
  /// pixel format has no conversion.
  Image8 convert(const AVFrame& frame);

 private:
  SwsContext* context_ = nullptr;  // kept between frames of one format
};

}  // namespace tessera
