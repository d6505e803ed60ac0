// What: clocks from measured pairs and shifts from epipolar misses, against closed forms.
// Not: measurements on pictures (sync_motion_test.cpp).
#include "ingest/offset_solver.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera {
namespace {

// The middle of 0.5, 0.7, −0.3 is 0.5, so the clocks are 0, 0.2 and −0.8; pairs that agree exactly
// leave only rounding. Bugs put back: offset taken as a − b; the mean for the median, the upper
// middle of an even count; each seen to fail.
TEST(OffsetSolver, PairsThatAgreeGiveExactClocks) {
  const std::vector<PairOffset> pairs{{0, 1, 0.2, 0.01}, {1, 2, -1.0, 0.02}, {0, 2, -0.8, 0.01}};
  const auto clocks = solve_offsets(3, pairs);
  const double expected[] = {0, 0.2, -0.8};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(clocks[i].offset, expected[i], 1e-12);
    EXPECT_TRUE(clocks[i].determined);
  }
  EXPECT_EQ(median_offset({3, 1, 2, 4}), 2) << "of an even count the lower one, a clock that stays";
}

// Two clocks and one pair of error s: about their mean each has s/2. The variance for the
// error: seen to fail.
TEST(OffsetSolver, ErrorsFollowFromThePairs) {
  const auto clocks = solve_offsets(2, {{0, 1, 0.3, 0.02}});
  EXPECT_NEAR(clocks[0].sigma, 0.01, 1e-12);
  EXPECT_NEAR(clocks[1].sigma, 0.01, 1e-12);
}

// One of ten pairs lies by a second, which plain least squares would share out among the clocks
// (0.2 s at best). All weights kept: seen to fail.
TEST(OffsetSolver, OnePairThatLiesIsOutvoted) {
  const double truth[] = {0, 0.1, -0.2, 0.05, -0.03};
  std::vector<PairOffset> pairs;
  for (int a = 0; a < 5; ++a)
    for (int b = a + 1; b < 5; ++b) pairs.push_back({a, b, truth[b] - truth[a], 0.01});
  pairs[3].offset += 1;
  const auto clocks = solve_offsets(5, pairs);
  for (size_t i = 0; i < 5; ++i) EXPECT_NEAR(clocks[i].offset, truth[i], 2e-3);
}

// Every clock counted as determined: seen to fail.
TEST(OffsetSolver, ClocksWithoutPairsAreLeftOpen) {
  const auto clocks = solve_offsets(5, {{1, 2, 0.5, 0.01}, {2, 4, 0.1, 0.01}});
  EXPECT_FALSE(clocks[0].determined);
  EXPECT_FALSE(clocks[3].determined);
  EXPECT_EQ(clocks[0].offset, 0);
  EXPECT_TRUE(clocks[1].determined && clocks[2].determined && clocks[4].determined);
  EXPECT_NEAR(clocks[4].offset - clocks[1].offset, 0.6, 1e-12);
  EXPECT_FALSE(solve_offsets(2, {})[0].determined);
}

/// Points of speeds −60 … 60 pixels a second whose second clock is `shift` seconds early; one in
/// four is a wrong match.
std::vector<EpipolarMiss> misses_of(double shift) {
  std::vector<EpipolarMiss> misses;
  for (int i = 0; i < 200; ++i) {
    const double slope = -60 + 120 * ((i * 37) % 200) / 199.0;
    misses.push_back({i % 4 == 0 ? 11 * std::sin(5.0 * i) : slope * shift, slope});
  }
  return misses;
}

// Exact misses of three in four points: the wrong quarter pulls by less than a hundredth of a
// frame. Bugs put back: the sign of the shift; weights that do not fall with the miss; each seen
// to fail.
TEST(OffsetSolver, ShiftIsWhatMostMissesAgreeOn) {
  const double frame = 1 / 30.0;
  for (const double frames : {-2.5, -0.3, 0.0, 0.25, 1.7}) {
    const auto found = shift_from_misses(misses_of(frames * frame), 4 * frame, frame);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->shift / frame, frames, 0.01);
    EXPECT_GE(found->support, 135u) << "three in four, less the tenth that hardly moves";
  }
}

// Points that stand still, and matches of which any shift would be right, say nothing of time.
// Bugs put back: no least slope; no least share of agreement; each seen to fail.
TEST(OffsetSolver, NoShiftWithoutEvidence) {
  std::vector<EpipolarMiss> still(200, {0.02, 0.5}), noise;  // would agree on 0.04 s
  EXPECT_FALSE(shift_from_misses(still, 0.1, 1 / 30.0));
  for (int i = 0; i < 1000; ++i) noise.push_back({12 * std::sin(7.3 * i), 60 * std::cos(3.1 * i)});
  EXPECT_FALSE(shift_from_misses(noise, 0.1, 1 / 30.0));
}

}  // namespace
}  // namespace tessera
