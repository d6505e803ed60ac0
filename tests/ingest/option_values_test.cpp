// Values of ingest options that no capture can have.
#include <gtest/gtest.h>

#include <limits>

#include "ingest/ingest.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;

// Bugs put back, each seen to fail: a check left out; --start compared so that NaN passes.
TEST(OptionValues, EachIsNamedWithItsValue) {
  using Options = IngestOptions;
  const auto expect_refused = [](auto set, const std::vector<std::string>& parts) {
    Options options;
    set(options);
    expect_input_error([&] { check_values(options); }, parts);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused([](Options& o) { o.scale = 0; }, {"--scale is 0"});
  expect_refused([](Options& o) { o.scale = 1.5; }, {"--scale is 1.5"});
  expect_refused([](Options& o) { o.frames = 0; }, {"--frames is 0", "leave it out"});
  expect_refused([](Options& o) { o.start = -1; }, {"--start is -1"});
  expect_refused([&](Options& o) { o.start = nan; }, {"--start is nan"});
  expect_refused([](Options& o) { o.duration = 0; }, {"--duration is 0"});
  expect_refused([&](Options& o) { o.fps = nan; }, {"--fps is nan"});
  expect_refused([](Options& o) { o.cloud_points = 0; }, {"--cloud-points is 0"});
  check_values({});
}

}  // namespace
}  // namespace tessera
