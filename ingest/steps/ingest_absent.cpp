// Implements ingest_capture in the trainer-only build: it throws an InputError that names the build
// with the converters.
#include "ingest/ingest.h"
#include "ingest/prepared/scene_clip.h"
#include "kernels/base/errors.h"

namespace tessera {

IngestReport ingest_capture(const std::filesystem::path& capture, const std::filesystem::path&,
                            const IngestOptions&, const IngestProgress&) {
  throw InputError(capture.string() +
                   ": this is the trainer-only build, which cannot prepare captures; prepare it "
                   "with a build configured with -DTESSERA_INGEST=ON and copy the result here");
}

const ClipReader* video_clip_reader() {
  return nullptr;
}

std::vector<std::pair<std::string, std::string>> media_versions() {
  return {};
}

}  // namespace tessera
