// Cameras of another frame rate are named by rate.
#include "ingest/clocks/frame_rates.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Bug put back: a camera of one frame compared; seen to fail. Rates that differ by less than 2 %
// are one.
TEST(FrameRates, ThoseThatDifferHaveTheirOwnText) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(rate_texts({1 / 30.0, 1 / 24.0, 1001 / 24000.0, 0}),
            (Texts{"30 frames/s", "24 frames/s", "24 frames/s", "24 frames/s"}));
  EXPECT_EQ(rate_texts({0.04, 1001 / 60000.0, 0.04}),
            (Texts{"25 frames/s", "59.94 frames/s", "25 frames/s"}));
  EXPECT_EQ(rate_texts({1 / 30.0, 0, 0}), (Texts{"", "", ""})) << "one rate";
  EXPECT_EQ(odd_rates({1 / 30.0, 1001 / 30000.0, 0}), (std::vector<char>{0, 0, 0}));
}

TEST(FrameRates, ARateThatNoCameraHasIsNamed) {
  EXPECT_EQ(fps_warning(60, {1 / 24.0, 0.04, 0}),
            "--fps 60: the videos have 25 frames/s, all of which are kept; no frame is made up");
  EXPECT_EQ(fps_warning(25, {1 / 24.0, 1 / 25.0}), "");
  EXPECT_EQ(fps_warning(30, {1001 / 30000.0}), "");
  EXPECT_EQ(fps_warning(30, {0}), "") << "one frame";
}

}  // namespace
}  // namespace tessera
