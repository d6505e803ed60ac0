// A build without ingest reports which build prepares captures. It is linked only where FFmpeg and
// the image libraries are absent.
#include "ingest/ingest.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

TEST(IngestAbsent, NamesTheBuildThatCan) {
  testing::expect_input_error([] { ingest_capture("capture", "out", {}, {}); },
                              {"capture", "trainer-only", "TESSERA_INGEST=ON"});
}

}  // namespace
}  // namespace tessera
