// Replaces the JPEG encoder in a build without FFmpeg: it returns no bytes.
#include "tools/video/jpeg.h"

namespace tessera {

std::optional<std::string> jpeg_bytes(const Image8&, int) {
  return std::nullopt;
}

}  // namespace tessera
