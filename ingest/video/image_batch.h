// What: decoded frames → RGB on all cores, handed over in order on the calling thread.
// Not: decoding; frames wait here only until there is one for each thread.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "ingest/video/libav_handles.h"
#include "ingest/video/video_colour.h"
#include "ingest/video/video_decoder.h"
#include "ingest/video/video_file.h"

namespace tessera {

class ImageBatch {
 public:
  ImageBatch(const VideoFile& file, const DecodeOptions& options,
             const std::function<bool(VideoFrame)>& on_frame);

  /// Takes the frame's reference. False once `on_frame` wants no more.
  bool add(AVFrame& frame);
  /// Hands over what waits; false once `on_frame` wants no more. Errors: InputError for a pixel
  /// format without a conversion.
  bool deliver();
  int64_t delivered() const { return delivered_; }

 private:
  std::string name_;
  ImageShape shape_;
  const std::function<bool(VideoFrame)>& on_frame_;
  std::vector<FrameToRgb> converters_;  // one a waiting frame
  std::vector<LibavOwned<AVFrame>> frames_;
  size_t waiting_ = 0;
  int64_t delivered_ = 0;
  bool stopped_ = false;
};

}  // namespace tessera
