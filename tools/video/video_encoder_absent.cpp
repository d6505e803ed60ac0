// Replaces the encoders in a build without FFmpeg: a video is an error that names the build option
// to set, and an image has no JPEG bytes.
#include "kernels/base/errors.h"
#include "tools/video/video_encoder.h"

namespace tessera {

struct VideoEncoder::State {};

VideoEncoder::VideoEncoder(const std::filesystem::path& path, const VideoFormat&) {
  throw InputError(path.string() +
                   ": cannot be written: this build has no FFmpeg; leave video out, "
                   "or build with TESSERA_INGEST=ON");
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

std::optional<std::string> jpeg_bytes(const Image8&, int) {
  return std::nullopt;
}

}  // namespace tessera
