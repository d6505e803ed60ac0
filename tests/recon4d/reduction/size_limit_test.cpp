// The exact size of the final model by count, bytes and decibels, and Gaussians that no training
// frame sees. Source: failure modes C12, C13.
#include "recon4d/reduction/size_limit.h"

#include <gtest/gtest.h>

#include "tests/recon4d/model/plain_gaussians.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

struct Contracted {
  GaussianModel model = random_model(40, 25, 7, 4);
  Scene scene = tiny_capture({6, 3, 24});

  Contracted() {
    for (size_t i = 0; i < 3; ++i) scene.frames[i].split = Split::kTest;
  }
  GaussianModel fitted(const SizeLimit& limit) const {
    const std::unique_ptr<Backend> backend = make_cpu_backend();
    return fit_to_limit(limit, *backend, model, sample_training_frames(scene));
  }
  int64_t count(const SizeLimit& limit) const { return fitted(limit).count(); }
  std::vector<RenderedImage> images(const GaussianModel& model, Split split) const {
    FrameSample sample;
    sample.scene = &scene;
    for (const int i : scene.split_indices(split)) sample.frames.push_back(i);
    return images_of(model, sample);
  }
};

/// Puts elements where no camera looks, too faint to be drawn, or no Gaussians at all.
int64_t hide(GaussianModel& model) {
  const GaussianSpans<float> fixed = model.static_set.values(), moving = model.dynamic_set.values();
  for (const int64_t n : {0, 7, 39}) fixed.at(kMean, n)[1] += 50;
  *fixed.at(kOpacityLogit, 12) = -8;
  for (int k = 0; k < 4; ++k) fixed.at(kRotation, 20)[k] = 0;
  *moving.at(kMeanTime, 3) = 30;
  for (int k = 0; k < 3; ++k) moving.at(kMean, 24)[k] += 70;
  return 7;
}

// C12. Bug put back: one more than the unseen removed; seen to fail.
TEST(SizeLimit, UnseenGaussiansAreRemovedAndNoImageChanges) {
  Contracted c;
  const int64_t hidden = hide(c.model);
  const GaussianModel fitted = c.fitted({});
  EXPECT_EQ(fitted.count(), c.model.count() - hidden);
  const std::vector<RenderedImage> before = c.images(c.model, Split::kTrain);
  const std::vector<RenderedImage> after = c.images(fitted, Split::kTrain);
  for (size_t i = 0; i < before.size(); ++i) EXPECT_TRUE(same_bits(before[i], after[i])) << i;
  const std::vector<RenderedImage> held = c.images(c.model, Split::kTest);
  const std::vector<RenderedImage> held_after = c.images(fitted, Split::kTest);
  ASSERT_EQ(held.size(), 3u);
  for (size_t i = 0; i < held.size(); ++i)
    expect_near_all(held_after[i].rgb, held[i].rgb, 1e-4, "held out");
}

// A black Gaussian before black adds no error by going, but it is seen. Bug put back: equals of
// price in the order of elements, seen or not; seen to fail.
TEST(SizeLimit, WhatIsSeenStaysHoweverLittleItDoes) {
  Contracted c;
  c.model = empty_model();
  c.model.static_set = plain_set(c.model.static_set, {{{0, 0, 0}, {0, 0, 0}, 0.3}, {{0, 50, 0}}});
  const GaussianModel fitted = c.fitted({});
  ASSERT_EQ(fitted.count(), 1);
  EXPECT_EQ(fitted.static_set.values().at(kMean, 0)[1], 0.0f);
}

// C13. Bug put back: one more than was asked for; seen to fail.
TEST(SizeLimit, SoManyAsAreAskedForOrAll) {
  Contracted c;
  const int64_t seen = c.model.count() - hide(c.model);
  for (int64_t asked : {1, 2, 33, 57, 58, 59, 1000})
    EXPECT_EQ(c.count({asked}), std::min(asked, seen)) << asked;
}

// Bug put back: the smallest that does not fit; seen to fail.
TEST(SizeLimit, TheLargestFileThatFits) {
  const Contracted c;
  SizeLimit limit;
  int asked = 0;
  limit.shipped_bytes = [&](const GaussianModel& model) {
    ++asked;
    return 100 + 30 * model.static_set.count() + 50 * model.dynamic_set.count();
  };
  const int64_t all = limit.shipped_bytes(c.model);
  for (const int64_t bytes : {all, all - 1, all / 2, int64_t{400}}) {
    limit.bytes = bytes;
    asked = 0;
    const GaussianModel fitted = c.fitted(limit);
    EXPECT_LE(limit.shipped_bytes(fitted), bytes);
    EXPECT_GT(limit.shipped_bytes(fitted) + 50, bytes == all ? all : bytes) << fitted.count();
    EXPECT_LT(asked, 15) << "by halving";
  }
  limit.bytes = 50;
  EXPECT_EQ(c.count(limit), 0) << "not even the header fits";
}

// Bug put back: halved to a thousandth there, too, which is three; seen to fail.
TEST(SizeLimit, OneGaussianIsLeftWhereOneFits) {
  Contracted c;
  c.model = random_model(3000, 0, 7, 1);
  SizeLimit limit;
  limit.shipped_bytes = [](const GaussianModel& model) { return 100 + 30 * model.count(); };
  limit.bytes = 130;
  EXPECT_EQ(c.count(limit), 1);
}

// Bug put back: the largest that is too bad; seen to fail.
TEST(SizeLimit, TheSmallestThatIsGoodEnough) {
  const Contracted c;
  SizeLimit limit;
  limit.psnr = [](const GaussianModel& model) { return double(model.count()); };
  for (const double least : {65.0, 64.0, 40.5, 3.0, 0.5}) {
    limit.least_psnr = least;
    EXPECT_EQ(c.count(limit), int64_t(std::ceil(least))) << least;
  }
  limit.least_psnr = 100;
  EXPECT_EQ(c.count(limit), 65) << "none is good enough: as it is";
}

// Bug put back: the largest contribution removed first; seen to fail.
TEST(SizeLimit, IsMetByWhatIsWorthLeastInTheTrainingFrames) {
  Contracted c;
  c.model = empty_model();
  c.model.static_set = plain_set(c.model.static_set, {{{0, 0.3, 0}, {0.9, 0.9, 0.9}, 0.3},
                                                      {{0, -0.5, 0}, {0.6, 0.6, 0.6}, 0.05},
                                                      {{0.5, 0, 0}, {0.9, 0.1, 0.1}, 0.2}});
  const GaussianModel fitted = c.fitted({2});
  ASSERT_EQ(fitted.static_set.count(), 2);
  EXPECT_EQ(fitted.static_set.values().at(kMean, 0)[1], 0.3f);
  EXPECT_EQ(fitted.static_set.values().at(kMean, 1)[0], 0.5f) << "in the order that they had";
}

}  // namespace
}  // namespace tessera::testing
