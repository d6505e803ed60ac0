// Cameras of another frame rate are named by rate.
#include "ingest/clocks/frame_rates.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Bugs put back, each seen to fail: the first camera's rate taken for the others'; a camera of one
// frame compared.
TEST(FrameRates, TheOddOneIsNamedByRate) {
  for (const double alike : {1 / 24.0, 1001 / 24000.0}) {
    const std::string warning =
        rate_warning({"cam00", "cam01", "cam02", "cam03"}, {1 / 30.0, 1 / 24.0, alike, 0});
    EXPECT_TRUE(warning.starts_with("cam00 has 30 frames/s, the others 24: ")) << warning;
  }
  EXPECT_EQ(rate_warning({"a", "b", "c"}, {1 / 30.0, 1001 / 30000.0, 0}), "");
  EXPECT_EQ(rate_warning({"a", "b", "c"}, {1 / 30.0, 0, 0}), "");
}

TEST(FrameRates, SeveralAreNamedEachWithItsRate) {
  const std::string several =
      rate_warning({"a", "b", "c", "d", "e"}, {0.04, 1001 / 60000.0, 0.04, 0.04, 0.05});
  EXPECT_TRUE(several.starts_with("b has 59.94 frames/s, e has 20 frames/s, the others 25: "))
      << several;
  const std::string two = rate_warning({"a", "b"}, {0.04, 0.05});
  EXPECT_TRUE(two.starts_with("b has 20 frames/s, the other 25: ")) << two;
}

}  // namespace
}  // namespace tessera
