// Demotion of dynamic Gaussians to static ones on scenes with a known answer, and the static form
// against the slice that it replaces. Source: failure modes, "Modelling no more than a scene
// needs".
#include "recon4d/reduction/static_demotion.h"

#include <gtest/gtest.h>

#include "kernels/load_gaussian.h"
#include "tests/recon4d/model/plain_gaussians.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

constexpr SetForm kForms[] = {SetForm::kPair, SetForm::kVelocity};

/// The result of try_demotion for a model whose images are the truth.
DemotionTrial tried(const GaussianModel& model, double allowed, int rounds = 4) {
  const Scene scene = tiny_capture({6, 6, 24}, model);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const FrameSample sample = sample_training_frames(scene);
  return try_demotion(*backend, model, measure_contributions(*backend, model, sample), sample,
                      allowed, rounds);
}

/// A static Gaussian below and these dynamic ones.
GaussianModel model_with(SetForm form, const std::vector<Plain>& moving) {
  GaussianModel model = empty_model(form);
  model.static_set = plain_set(model.static_set, {{{0, -0.9, 0}, {0.3, 0.6, 0.4}, 0.1}});
  model.dynamic_set = plain_set(model.dynamic_set, moving);
  return model;
}

constexpr double kAllowed = 0.05;  // squared error; each of these adds at least ten times that

// Bug put back: the limit ignored; seen to fail.
TEST(StaticDemotion, WhatLastsAndDoesNotMoveIsAccepted) {
  const Plain still{{0, -0.4, 0}, {0.9, 0.4, 0.1}, 0.1, 0.8};
  Plain moves = still, half = still;
  moves.speed = 1.2;
  moves.mean = {0.2, 0.3, 0.2};
  half.mean_time = 0;
  half.sigma_time = 0.25;
  half.mean = {-0.2, 0.8, 0};
  for (const SetForm form : kForms) {
    const DemotionTrial alone = tried(model_with(form, {still}), kAllowed);
    EXPECT_EQ(alone.elements, (std::vector<int64_t>{0}));
    EXPECT_EQ(alone.demoted.count(), 1);
    EXPECT_LT(alone.error, 1e-3);
    EXPECT_TRUE(tried(model_with(form, {half}), kAllowed).elements.empty())
        << "there half the time";
    if (form == SetForm::kPair) continue;
    EXPECT_TRUE(tried(model_with(form, {moves}), kAllowed).elements.empty()) << "moves";
    const DemotionTrial all = tried(model_with(form, {moves, still, half, still}), kAllowed);
    EXPECT_EQ(all.elements, (std::vector<int64_t>{1, 3})) << "told apart in one scene";
    EXPECT_EQ(all.demoted.count(), 2);
  }
}

// Those that stand still for the most part of their light are tried, whatever else there is. Bugs
// put back, each seen to fail: nearly all are tried; masks of the passes left at the frames' own.
TEST(StaticDemotion, OnlyWhatMasksSayIsStillIsTried) {
  const GaussianModel model = model_with(
      SetForm::kPair, {{{0, 0.5, 0}, {0.9, 0.4, 0.1}, 0.1}, {{0, -0.4, 0}, {0.2, 0.4, 0.9}, 0.1}});
  const Scene scene = tiny_capture({6, 6, 24}, model);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  FrameSample sample = sample_training_frames(scene);
  const auto elements = [&] {
    return try_demotion(*backend, model, measure_contributions(*backend, model, sample), sample,
                        kAllowed)
        .elements;
  };
  EXPECT_EQ(elements(), (std::vector<int64_t>{0, 1})) << "nothing is known";
  std::vector<uint8_t> still(24 * 24, kStillPixel), upper = still;
  const std::vector<uint8_t> moves(24 * 24, kMovingPixel);
  std::fill_n(upper.begin(), 24 * 12, kMovingPixel);
  const auto with = [&](const std::vector<uint8_t>& mask) {
    sample.moving.assign(size_t(sample.count()), {mask.data(), int64_t(mask.size())});
    return elements();
  };
  EXPECT_EQ(with(still), (std::vector<int64_t>{0, 1}));
  EXPECT_EQ(with(moves), std::vector<int64_t>{});
  EXPECT_EQ(with(upper).size(), 1u) << "one is in the upper half of the images";
}

// A colour that changes at rest: one Gaussian fades out as the other fades in, and each alone could
// be static. Bug put back:
// one round, whatever is left; seen to fail.
TEST(StaticDemotion, AChangeOfColourIsMotion) {
  Plain before{{0, 0.6, 0}, {0.9, 0.1, 0.1}, 0.12, 0.9, 0, 0.35}, after = before;
  after.colour = {0.1, 0.2, 0.9};
  after.mean_time = 1;
  const Plain still{{0, -0.3, 0}, {0.4, 0.8, 0.1}, 0.1, 0.8};
  for (const SetForm form : kForms)
    EXPECT_EQ(tried(model_with(form, {before, still, after}), kAllowed).elements,
              (std::vector<int64_t>{1}));
  // nothing moves, but the light changes
  Plain dims = still;
  dims.mean_time = -0.5;
  dims.sigma_time = 0.7;
  EXPECT_TRUE(tried(model_with(SetForm::kPair, {dims}), kAllowed).elements.empty());
}

// Bug put back: elements without light tried; seen to fail.
TEST(StaticDemotion, AcceptsWhatIsAllowedAndNothingUnseen) {
  const Plain lasting{{0, 0.5, 0}, {0.9, 0.4, 0.1}, 0.2, 0.8, 0.5, 1.5};  // fades by 5 %
  Plain unseen = lasting;
  unseen.mean = {0, 50, 0};
  const GaussianModel model = model_with(SetForm::kPair, {unseen, lasting});
  const DemotionTrial generous = tried(model, 1e6);
  EXPECT_EQ(generous.elements, (std::vector<int64_t>{1}));
  EXPECT_GT(generous.error, 0);
  EXPECT_EQ(tried(model, 1.01 * generous.error + 1e-6).elements, generous.elements);
  EXPECT_TRUE(tried(model, 0.5 * generous.error).elements.empty());
  EXPECT_EQ(tried(model, 0.5 * generous.error).error, 0);
}

// Bug put back: the error of what was tried, not of what is left; seen to fail.
TEST(StaticDemotion, TheErrorIsOfWhatIsLeft) {
  std::vector<Plain> dynamic = {{{0, 0.7, 0}, {0.9, 0.4, 0.1}, 0.15, 0.8, 0.5, 1.5}};  // fades
  for (int n = 0; n < 4; ++n)
    dynamic.push_back({{0.4 * n - 0.6, -0.2, 0}, {0.4, 0.8, 0.1}, 0.1, 0.8});  // these last
  const GaussianModel model = model_with(SetForm::kPair, dynamic);
  const double all = tried(model, 1e6).error;
  const DemotionTrial one_round = tried(model, 0.25 * all, 1);
  EXPECT_EQ(one_round.elements, (std::vector<int64_t>{1, 2, 3, 4}));
  EXPECT_LT(one_round.error, 0.1 * all);
}

/// Every Gaussian's slice at t as its timestep and opacity.
SetContributions at_timestep(const GaussianModel& model, float t) {
  SetContributions contributions;
  contributions.resize(model.dynamic_set.count());
  const GaussianSpans<const float> values = model.dynamic_set.values();
  for (int64_t n = 0; n < values.count; ++n) {
    GaussianState<float> g{};
    values.form == SetForm::kPair ? load_gaussian<SetForm::kPair>(values, n, g)
                                  : load_gaussian<SetForm::kVelocity>(values, n, g);
    contributions.weight[size_t(n)] = 1;
    contributions.mean_time[size_t(n)] = t;
    contributions.opacity[size_t(n)] = g.opacity * slice_at(g.mean, g.spacetime, t).marginal;
  }
  return contributions;
}

// Bugs put back, each seen to fail: the opacity of the Gaussian; levels of time left out.
TEST(StaticDemotion, TheStaticFormDrawsTheSliceAtItsTimestep) {
  for (const SetForm form : kForms)
    for (const float t : {0.1f, 0.5f, 0.8f})
      for (const int levels : {0, 2}) {
        const GaussianModel model = levels == 0 ? random_model(0, 15, 7, 16, form)
                                                : random_model_in_time(0, 15, 2, 7, 16, form);
        GaussianModel still = model.clone_values();
        still.static_set = as_static(*make_cpu_backend(), model, at_timestep(model, t));
        still.dynamic_set = model.dynamic_set.like();
        still.dynamic_set.resize(0);
        EXPECT_EQ(still.static_set.count(), 15);
        for (View view : three_views()) {
          view.time = double(t);
          const RenderedImage expected = render_one(model, view);
          EXPECT_GT(coverage(expected), 0.01);
          expect_same_image(render_one(still, view), expected);
        }
      }
}

// Bug put back: elements without light placed too; seen to fail.
TEST(StaticDemotion, WithoutLightItStaysWhereItsOwnTimestepHasIt) {
  const GaussianModel model = random_model(0, 5, 7, 4, SetForm::kVelocity);
  SetContributions contributions;
  contributions.resize(5);
  const GaussianSet still = as_static(*make_cpu_backend(), model, contributions);
  for (const Group group : {kMean, kLogScale, kRotation, kOpacityLogit})
    for (int64_t i = 0; i < still.group(group).value.size(); ++i)
      EXPECT_EQ(still.group(group).value[i], model.dynamic_set.group(group).value[i]);
}

}  // namespace
}  // namespace tessera::testing
