// The error of a decision from half of the frames, computed by hand, and the end of a pass.
#include "recon4d/reduction/contributions.h"

#include <gtest/gtest.h>

namespace tessera::testing {
namespace {

// Bugs put back, each seen to fail: one direction alone; the price of both halves.
TEST(Precision, RegretByHand) {
  EXPECT_EQ(regret({0.5, 3}, {0.5, 3}, {1, 1}), 0);
  EXPECT_EQ(regret({0.1, 5}, {0.9, 2}, {1, 1}), 0) << "both halves decide alike";
  // the first gives it up, which costs 10 where 1 would do; the second keeps it for 1 instead of 0
  EXPECT_DOUBLE_EQ(regret({0}, {10}, {1}), (10.0 - 1 + 1 - 0) / 2);
  EXPECT_DOUBLE_EQ(regret({10}, {0}, {1}), regret({0}, {10}, {1}));
  EXPECT_DOUBLE_EQ(regret({0, 4}, {10, 4}, {1, 3}), 5);
  EXPECT_DOUBLE_EQ(regret({-2}, {1.5}, {1}), (0.5 + 3) / 2) << "a change may help";
  EXPECT_EQ(regret({}, {}, {}), 0);
  EXPECT_EQ(regret({0}, {0}, {0}), 0);
}

/// 8 sweeps of ten frames of a scene, each of a megapixel.
FrameSample eight_sweeps(const Scene& scene) {
  FrameSample sample;
  sample.scene = &scene;
  for (int k = 0; k < 8; ++k) sample.sweeps.push_back({10 * k, 10 * k + 10});
  sample.frames.resize(80);
  return sample;
}

/// Sweeps after which a pass over one element ends; each sweep adds what `error` has for it.
int64_t sweeps_drawn(const std::vector<double>& error, double price, bool asks = true,
                     double squared_error = 0) {
  Scene scene;
  scene.frames.resize(1);
  scene.frames[0].camera.width = scene.frames[0].camera.height = 1024;
  const FrameSample sample = eight_sweeps(scene);
  int64_t next = 0;
  double sum = 0;
  const auto draw = [&](int64_t begin, int64_t end) {
    EXPECT_EQ(begin, next);
    EXPECT_LE(end - begin, 4);
    EXPECT_EQ(begin / 10, (end - 1) / 10) << "of one sweep";
    next = end;
    if (begin % 10 == 0) sum += error[size_t(begin / 10)];
  };
  const auto so_far = [&](double share) {
    EXPECT_DOUBLE_EQ(share, double(next) / 80);
    return PricedErrors{{sum}, {price * share}, squared_error * share};
  };
  const double share =
      draw_until_precise(sample, draw, asks ? so_far : std::function<PricedErrors(double)>());
  EXPECT_DOUBLE_EQ(share, double(next) / 80);
  return next / 10;
}

// Bugs put back, each seen to fail: all that was drawn against the first half; the price of all
// frames for a half.
TEST(Precision, APassEndsWhenItsHalvesDecideAlike) {
  EXPECT_EQ(sweeps_drawn({1, 1, 1, 1, 1, 1, 1, 1}, 16), 2) << "each adds half of its price";
  EXPECT_EQ(sweeps_drawn({3, 3, 3, 3, 3, 3, 3, 3}, 32), 2) << "both halves together exceed one's";
  EXPECT_EQ(sweeps_drawn({1, 1, 1, 1, 1, 1, 1, 1}, 4), 2) << "each adds twice its price";
  EXPECT_EQ(sweeps_drawn({0, 8, 4, 4, 4, 4, 4, 4}, 24), 4) << "halves of two do not agree";
  EXPECT_EQ(sweeps_drawn({0, 8, 0, 0, 0, 0, 0, 40}, 32), 4);
  EXPECT_EQ(sweeps_drawn({0, 9, 9, 9, 0, 9, 0, 0}, 40), 8) << "nor of four";
  EXPECT_EQ(sweeps_drawn({1, 1, 1, 1, 1, 1, 1, 1}, 16, false), 8) << "not requested";
}

// Bugs put back, each seen to fail: the squared error of both halves; that of all frames; the
// smaller of the two bounds.
TEST(Precision, WhatImagesDoNotShowIsPreciseEnough) {
  // two sweeps are a quarter: halves of 0 and 8 at prices of 3 lose (8 − 3 + 3) / 2
  const std::vector<double> error = {0, 8, 4, 4, 4, 4, 4, 4};
  const double enough = 8 * 4 / kRegretOfError;  // of eight sweeps, where 4 are the bound of one
  EXPECT_EQ(sweeps_drawn(error, 24, true, 1.01 * enough), 2);
  EXPECT_EQ(sweeps_drawn(error, 24, true, 0.99 * enough), 4);
}

}  // namespace
}  // namespace tessera::testing
