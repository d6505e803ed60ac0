// Converts a decoded frame of any pixel format to upright 8-bit RGB with the matrix and range of
// the video. Primaries and transfer curve stay those of the video.
#pragma once
#include "ingest/scene.h"
#include "ingest/video/video_file.h"

struct SwsContext;

namespace tessera {

struct ImageShape {
  int quarter_turns = 0;      // clockwise, 0 to 3
  int width = 0, height = 0;  // of the upright image, area averages; 0: as the frame
};

class FrameToRgb {
 public:
  FrameToRgb();
  ~FrameToRgb();
  FrameToRgb(const FrameToRgb&) = delete;
  FrameToRgb& operator=(const FrameToRgb&) = delete;

  /// Unstated matrices are BT.601 below 720 lines, BT.709 from there. An empty image where the
  /// pixel format or the colour matrix has no conversion.
  Image8 convert(const AVFrame& frame, const ImageShape& shape);

 private:
  SwsContext* context_ = nullptr;  // kept between frames of one format
  LibavOwned<AVFrame> planes_;     // kept too: new pages cost as much as the conversion
};

}  // namespace tessera
