// Cameras that film in other colours than most of them are named.
#include "ingest/checks/mixed_colours.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

FrameColour colour(TransferCurve transfer, ColourPrimaries primaries) {
  FrameColour made;
  made.transfer = transfer;
  made.primaries = primaries;
  return made;
}

// Bugs put back, each seen to fail: the first camera's colour taken for the others'; primaries not
// compared.
TEST(MixedColours, TheOddOnesAreNamed) {
  const FrameColour sdr;
  const FrameColour hlg = colour(TransferCurve::kHlg, ColourPrimaries::kBt2020);
  const FrameColour wide = colour(TransferCurve::kSdr, ColourPrimaries::kBt2020);
  const std::string one = mixed_colours({"a", "b", "c"}, {hlg, sdr, sdr});
  EXPECT_TRUE(one.starts_with("a is HLG, the others SDR: ")) << one;
  const std::string several = mixed_colours({"a", "b", "c", "d"}, {hlg, wide, sdr, hlg});
  EXPECT_TRUE(several.starts_with("b is SDR in BT.2020, c is SDR, the others HLG: ")) << several;
  const std::string two = mixed_colours({"a", "b"}, {sdr, wide});
  EXPECT_TRUE(two.starts_with("b is SDR in BT.2020, the other SDR: ")) << two;
}

TEST(MixedColours, OneColourIsNoMixture) {
  FrameColour turned_range;
  turned_range.full_range = true;
  turned_range.interlaced = true;
  EXPECT_EQ(mixed_colours({"a", "b"}, {FrameColour{}, turned_range}), "");
  const FrameColour pq = colour(TransferCurve::kPq, ColourPrimaries::kBt2020);
  EXPECT_EQ(mixed_colours({"a", "b"}, {pq, pq}), "");
  EXPECT_EQ(mixed_colours({"a"}, {pq}), "");
}

}  // namespace
}  // namespace tessera
