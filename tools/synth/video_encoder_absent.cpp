// What: stands in for the encoder in a build without FFmpeg: says so, and how to get it.
// Not: linked where FFmpeg is (video_encoder.cpp).
#include "kernels/base/errors.h"
#include "tools/synth/video_encoder.h"

namespace tessera::synth {

struct VideoEncoder::State {};

VideoEncoder::VideoEncoder(const std::filesystem::path& path, const VideoFormat&) {
  throw InputError("synth: cannot write " + path.string() +
                   ": this build has no FFmpeg; use the layout dnerf or build with "
                   "TESSERA_INGEST=ON");
}
VideoEncoder::~VideoEncoder() = default;

void VideoEncoder::add(const Image8&) {
  check(false, "an absent video encoder was used");
}
void VideoEncoder::finish() {
  check(false, "an absent video encoder was used");
}

bool video_encoder_available() {
  return false;
}

}  // namespace tessera::synth
