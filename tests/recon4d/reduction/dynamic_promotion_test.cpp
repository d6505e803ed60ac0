// Promotion to dynamic Gaussians: none from noise alone, and where a colour changes, one at the
// timestep and with the colour of the change. Source: failure modes, "Modelling no more than a
// scene needs".
#include "recon4d/reduction/dynamic_promotion.h"

#include <gtest/gtest.h>

#include "kernels/load_gaussian.h"
#include "kernels/math/random.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/element_edits.h"
#include "tests/recon4d/model/plain_gaussians.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

/// White noise of a deviation in 8-bit units on every value.
void add_white_noise(Scene& scene, double deviation, uint64_t seed) {
  uint64_t index = 0;
  for (Frame& frame : scene.frames)
    for (size_t i = 0; i < frame.image.data.size(); ++i) {
      const float normal = normals(philox(seed, RandomStream::kInitialise, index++))[0];
      const double value = frame.image.data[i] + deviation * double(normal);
      frame.image.data[i] = uint8_t(std::clamp(std::lround(value), 0l, 255l));
    }
}

/// Many small grey Gaussians before grey.
GaussianModel grey_crowd(int64_t count) {
  GaussianModel model = empty_model();
  Random random(11);
  std::vector<Plain> crowd;
  for (int64_t n = 0; n < count; ++n)
    crowd.push_back({random.array<3>(-0.9, 0.9), random.array<3>(0.4, 0.6),
                     random.uniform(0.03, 0.12), random.uniform(0.3, 0.9)});
  model.static_set = plain_set(model.static_set, crowd);
  model.background = {128, 128, 128};
  return model;
}

// With two timesteps, three degrees of freedom, the tail is longest. Bugs put back, each seen to
// fail: the tail of a normal distribution; degrees of freedom of one channel.
TEST(DynamicPromotion, NothingIsSpawnedByWhiteNoise) {
  const GaussianModel model = grey_crowd(2500);
  for (const int timesteps : {2, 3, 8})
    for (const double deviation : {1.0, 5.0, 20.0}) {
      Scene scene = tiny_capture({3, timesteps, 32}, model);
      add_white_noise(scene, deviation, uint64_t(timesteps));
      const Contributions contributions = contributions_of(model, scene);
      EXPECT_TRUE(time_varying_elements(contributions, 0, 1000).empty())
          << timesteps << " timesteps, deviation " << deviation << ": "
          << time_varying_elements(contributions, 0, 1000).size();
    }
}

/// Three spots side by side before a few cameras, and the images of a world in which the second
/// changes its colour at the timesteps 2 and 3 of 6, by most at 3.
struct Spots {
  GaussianModel model;
  Scene scene;

  explicit Spots(SetForm form = SetForm::kPair, int degree = 0) : model(empty_model(form, degree)) {
    TinyCapture capture{3, 6, 32};
    capture.arc = 0.3;
    const std::vector<Plain> spots = {{{0, 0, 0.7}, {0.7, 0.3, 0.3}, 0.12, 0.9},
                                      {{0, 0, 0.0}, {0.3, 0.4, 0.5}, 0.12, 0.9},
                                      {{0, 0, -0.7}, {0.4, 0.7, 0.3}, 0.12, 0.9}};
    model.static_set = plain_set(model.static_set, spots);
    scene = tiny_capture(capture, model);
    for (const auto& [timestep, red] : {std::pair{2, 0.1}, {3, 0.2}}) {
      GaussianModel other = model.clone_values();
      other.static_set.values().at(kSh, 1)[0] += float(red / kSh0);
      const Scene changed = tiny_capture(capture, other);
      for (size_t i = 0; i < scene.frames.size(); ++i)
        if (scene.frames[i].frame_number == timestep)
          scene.frames[i].image = changed.frames[i].image;
    }
    add_white_noise(scene, 1, 5);
  }
};

// Bug put back: pairs with r near l; seen to fail.
TEST(DynamicPromotion, WhereAColourChangesAtThatTimestepWithThatColour) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    const Spots spots(form, 1);
    const Contributions contributions = contributions_of(spots.model, spots.scene);
    const std::vector<int64_t> elements = time_varying_elements(contributions, 0, 10);
    ASSERT_EQ(elements, (std::vector<int64_t>{1}));
    const GaussianSet spawned =
        spawn_dynamic(*make_cpu_backend(), spots.model, contributions, elements);
    ASSERT_EQ(spawned.count(), 1);
    EXPECT_EQ(spawned.form(), form);
    const GaussianSpans<const float> to = spawned.values(), from = spots.model.static_set.values();
    EXPECT_EQ(*to.at(kMeanTime, 0), 0.6f);
    EXPECT_NEAR(sigmoid(*to.at(kOpacityLogit, 0)), 0.5f, 1e-6f);
    // twice what is missing, as half of it is seen; noise leaves a hundredth
    EXPECT_NEAR(to.at(kSh, 0)[0] - from.at(kSh, 1)[0], 0.4 / kSh0, 0.02 / kSh0);
    for (int i = 1; i < to.width(kSh); ++i)
      EXPECT_NEAR(to.at(kSh, 0)[i], from.at(kSh, 1)[i], 0.02 / kSh0) << i;
    // 1 + (1/2)² timesteps of six, half of that to each side
    EXPECT_NEAR(std::exp(*to.at(kLogScaleTime, 0)), 0.5 * 1.25 / 6, 0.01);
    GaussianState<float> g, still;
    ASSERT_TRUE(form == SetForm::kPair ? load_gaussian<SetForm::kPair>(to, 0, g)
                                       : load_gaussian<SetForm::kVelocity>(to, 0, g));
    ASSERT_TRUE(load_gaussian<SetForm::kStatic>(from, 1, still));
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(g.mean[k], still.mean[k]);
      EXPECT_NEAR(g.spacetime.velocity[k], 0, 1e-5) << "at rest";
    }
    EXPECT_NEAR(g.spacetime.covariance.xx, still.spacetime.covariance.xx, 1e-6);
    EXPECT_NEAR(g.spacetime.covariance.yz, still.spacetime.covariance.yz, 1e-6);
  }
}

// A promoted Gaussian is rendered as before over the clip. Bug put back: an extent of a tenth of
// the clip; seen to fail.
TEST(DynamicPromotion, WhatBecomesDynamicLooksAsItDid) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    const Spots spots(form, 1);
    const Contributions contributions = contributions_of(spots.model, spots.scene);
    GaussianModel moving = spots.model.clone_values();
    moving.dynamic_set = as_dynamic(*make_cpu_backend(), spots.model, contributions, {0, 2});
    moving.static_set = select_elements(spots.model.static_set, {1});
    ASSERT_EQ(moving.count(), spots.model.count());
    const auto backend = make_cpu_backend();
    std::vector<View> views;
    for (const double time : {0.0, 0.5, 1.0}) views.push_back({spots.scene.frames[0].camera, time});
    const std::vector<RenderedImage> before = render_views(*backend, spots.model, views);
    const std::vector<RenderedImage> after = render_views(*backend, moving, views);
    for (size_t i = 0; i < views.size(); ++i)
      for (size_t p = 0; p < before[i].rgb.size(); ++p)
        ASSERT_NEAR(after[i].rgb[p], before[i].rgb[p], views[i].time == 0.5 ? 2e-3 : 0.12)
            << views[i].time;
  }
}

// Bugs put back, each seen to fail: those with the least gain; `least` ignored.
TEST(DynamicPromotion, AtMostSoManyAndOnlyWhereTheErrorJustifiesTheirBytes) {
  Contributions contributions;
  contributions.squared_error = 100;
  contributions.samples = 100000;
  contributions.sets[0].resize(6);
  const float gains[] = {3, 9, 0.5f, 7, 5, 8};
  for (size_t n = 0; n < 6; ++n) {
    contributions.sets[0].change[n].gain = gains[n];
    contributions.sets[0].change[n].freedom = 3;
  }
  contributions.sets[0].change[5].freedom = 0;  // seen once in every series
  using Elements = std::vector<int64_t>;
  EXPECT_EQ(time_varying_elements(contributions, 0, 10), (Elements{0, 1, 2, 3, 4}));
  EXPECT_EQ(time_varying_elements(contributions, 0, 2), (Elements{1, 3}))
      << "the largest, ascending";
  EXPECT_EQ(time_varying_elements(contributions, 4, 10), (Elements{1, 3, 4}));
  contributions.share = 0.5;  // of the frames were drawn, so half of the gain
  EXPECT_EQ(time_varying_elements(contributions, 8, 10), (Elements{1, 3, 4}));
  EXPECT_EQ(time_varying_elements(contributions, 0, 0), Elements{});
  EXPECT_EQ(time_varying_elements(contributions, 0, -3), Elements{});
  EXPECT_EQ(time_varying_elements(contributions, 100, 10), Elements{});
}

// Bugs put back, each seen to fail: a share of the largest weight; unknown motion taken for none.
TEST(DynamicPromotion, OnlyWhereLightLiesInPixelsThatMayMove) {
  Contributions contributions;
  contributions.samples = 1;
  contributions.sets[0].resize(4);
  const float weights[] = {100, 10, 1, 10}, moving[] = {9, 2, 0.2f, 0};
  for (size_t n = 0; n < 4; ++n) {
    contributions.sets[0].weight[n] = weights[n];
    contributions.sets[0].moving[n] = moving[n];
    contributions.sets[0].change[n].gain = 1;
    contributions.sets[0].change[n].freedom = 1;
  }
  using Elements = std::vector<int64_t>;
  EXPECT_EQ(time_varying_elements(contributions, 0, 10), (Elements{0, 1, 2, 3})) << "not known";
  contributions.motion_known = true;
  EXPECT_EQ(time_varying_elements(contributions, 0, 10), (Elements{1, 2}));
}

}  // namespace
}  // namespace tessera::testing
