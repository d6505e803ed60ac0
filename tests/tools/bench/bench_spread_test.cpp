// Median and spread, Pareto front and knee on points with known answers.
#include "tools/bench/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tessera {
namespace {

using Indices = std::vector<size_t>;

// Bug put back: the upper of the middle two for an even number; seen to fail.
TEST(BenchSpread, MedianLeastAndMost) {
  const Spread odd = spread_of({3, 1, 10}).value();
  EXPECT_EQ(odd.median, 3);
  EXPECT_EQ(odd.least, 1);
  EXPECT_EQ(odd.most, 10);
  EXPECT_EQ(odd.count, 3);
  EXPECT_EQ(spread_of({4, 1, 2, 10})->median, 3);
  EXPECT_EQ(spread_of({7})->median, 7);
}

// Bug put back: what is not finite counts; seen to fail.
TEST(BenchSpread, WhatIsNotFiniteDoesNotCount) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(spread_of({nan, 2, infinite})->count, 1);
  EXPECT_FALSE(spread_of({nan}));
  EXPECT_FALSE(spread_of({}));
}

// Bug put back: points as good as a faster one stay; seen to fail.
TEST(BenchFrontier, KeepsWhatNoOtherBeats) {
  //            0: slow, best   1: fastest   2: beaten by 3   3         4: as good as 3, slower
  EXPECT_EQ(pareto_front_of({{100, 30}, {1, 20}, {20, 24}, {10, 25}, {12, 25}}),
            (Indices{1, 3, 0}));
  EXPECT_EQ(pareto_front_of({{5, 20}, {5, 22}, {5, 22}}), (Indices{1})) << "equal: the first";
  EXPECT_EQ(pareto_front_of({{1, 30}, {10, 20}}), (Indices{0})) << "the fastest is the best";
  EXPECT_TRUE(pareto_front_of({}).empty());
}

// Bug put back: seconds on a linear axis, which gives point 2; seen to fail.
TEST(BenchKnee, IsFarthestAboveTheLine) {
  // x = 0, 1/3, 2/3, 1 and y = 0, 0.762, 0.952, 1: farthest is point 1
  const std::vector<TimedScore> points = {{1, 20}, {10, 28}, {100, 30}, {1000, 30.5}, {50, 27}};
  EXPECT_EQ(knee_of(points), size_t{1});
}

// Bug put back: farthest from the line on either side; seen to fail.
TEST(BenchKnee, IsNoneWhereThereIsNoBend) {
  EXPECT_FALSE(knee_of({{1, 20}, {10, 21}})) << "two points";
  EXPECT_FALSE(knee_of({{1, 20}, {10, 20.5}, {100, 30}})) << "bent the other way";
  EXPECT_FALSE(knee_of({{10, 30}, {20, 25}, {30, 20}})) << "one on the frontier";
}

}  // namespace
}  // namespace tessera
