// What: the trainer-only build says which build prepares captures.
// Not: linked where FFmpeg and friends are there.
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
