// Converts a decoded frame of any pixel format to upright 8-bit sRGB with the matrix, range,
// transfer curve and primaries of the frame (frame_colour.h).
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

  /// SDR values are taken as sRGB; HLG, PQ and BT.2020 go through 16 bits and srgb_of. An empty
  /// image where the pixel format has no conversion, and where colour_refusal is not empty.
  Image8 convert(const AVFrame& frame, const ImageShape& shape);

 private:
  SwsContext* context_ = nullptr;  // kept between frames of one format
  LibavOwned<AVFrame> pixels_;     // kept too: new pages cost as much as the conversion
};

}  // namespace tessera
