// FFmpeg's version is that of the library in use; OpenCV's and OpenImageIO's are those of the
// build.
#include "ingest/video/media_versions.h"

extern "C" {
#include <libavutil/avutil.h>
}

#include <OpenImageIO/oiioversion.h>

#include <opencv2/core/version.hpp>

namespace tessera {

std::vector<std::pair<std::string, std::string>> media_versions() {
  return {
      {"FFmpeg", av_version_info()}, {"OpenCV", CV_VERSION}, {"OpenImageIO", OIIO_VERSION_STRING}};
}

}  // namespace tessera
