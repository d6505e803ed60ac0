// Gaussians that no training view shows: how they are found, and their removal, alone and in a
// training.
#include <gtest/gtest.h>

#include <set>

#include "recon4d/density/unseen.h"
#include "recon4d/evaluation/render.h"
#include "tests/support/random.h"
#include "tests/support/test_scene.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

constexpr double kLeast = 0.05;

void set_value(GaussianSet& set, Group group, int64_t n, std::vector<float> values) {
  std::copy(values.begin(), values.end(),
            set.group(group).value.data() + n * int64_t(values.size()));
}

/// A training state of that model, with moments and statistics that identify its elements.
TrainState state_of(GaussianModel model) {
  TrainState state;
  state.model = std::move(model);
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    set.ensure_moments();
    state.statistics[k].reset(set.count());
    for (int64_t n = 0; n < set.count(); ++n) {
      state.statistics[k].count[n] = float(n);
      set.group(kOpacityLogit).moment1[n] = float(10 + n);
    }
  }
  return state;
}

std::array<DensityReport, 2> prune(TrainState& state, const Scene& scene) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  Pipeline<float> pipeline(*backend);
  const GaussianModel& model = state.model;
  const ForwardArgs<float> forward{
      {model.static_set.values(), model.dynamic_set.values()}, {}, render_options(model)};
  const Buffer<float> largest =
      largest_weights(*backend, pipeline, forward, views_of_training(scene, 1000), 4);
  return prune_unseen(*backend, largest, kLeast, state);
}

// Bugs put back, each seen to fail: weights of the dynamic set read from the start of the list; the
// last batch of views left out; those kept that should go.
TEST(TrainUnseen, AGaussianInNoViewIsRemoved) {
  const TinyCapture capture{.cameras = 5, .timesteps = 4};
  const Scene scene = tiny_capture(capture);
  GaussianModel model = tiny_truth(capture);
  ASSERT_EQ(model.static_set.count(), 3);
  ASSERT_EQ(model.dynamic_set.count(), 2);
  set_value(model.static_set, kOpacityLogit, 0, {logit(0.03)});  // too faint
  set_value(model.static_set, kMean, 2, {0, 50, 0});             // beside all views
  for (int64_t n = 0; n < 2; ++n) {
    set_value(model.dynamic_set, kLogScaleTime, n, {std::log(0.02f)});
    set_value(model.dynamic_set, kMeanTime, n,
              {n == 1 ? 0.5f : 1.0f});  // between frames; at the last
  }
  const float kept_static = model.static_set.group(kMean).value[3];
  TrainState state = state_of(std::move(model));
  const std::array<DensityReport, 2> reports = prune(state, scene);
  EXPECT_EQ(reports[0].pruned, 2);
  EXPECT_EQ(reports[1].pruned, 1);
  ASSERT_EQ(state.model.static_set.count(), 1);
  ASSERT_EQ(state.model.dynamic_set.count(), 1);
  EXPECT_EQ(state.model.static_set.group(kMean).value[0], kept_static);
  EXPECT_EQ(state.model.dynamic_set.group(kMeanTime).value[0], 1.0f);
  EXPECT_EQ(state.statistics[0].count[0], 1.0f);
  EXPECT_EQ(state.statistics[1].count[0], 0.0f);
  EXPECT_EQ(state.model.static_set.group(kOpacityLogit).moment1[0], 11.0f);
}

TEST(TrainUnseen, AGaussianBehindAnOpaqueOneIsRemoved) {
  const TinyCapture capture{.cameras = 1, .timesteps = 1};
  GaussianModel model = tiny_truth(capture);
  const Scene scene = tiny_capture(capture);
  const Camera& camera = scene.frames[0].camera;
  const glm::dvec3 eye = -(glm::transpose(camera.cam_from_world) * camera.translation);
  for (const auto& [n, share] : {std::pair{0, 0.5}, std::pair{1, 0.8}, std::pair{2, 1.3}}) {
    const glm::dvec3 place = eye * (1 - share);  // on the axis, the last behind the origin
    set_value(model.static_set, kMean, n, {float(place.x), float(place.y), float(place.z)});
    set_value(model.static_set, kLogScale, n,
              std::vector<float>(3, std::log(n == 1 ? 0.4f : 0.01f)));
    set_value(model.static_set, kOpacityLogit, n, {logit(n == 1 ? 0.995 : 0.9)});
  }
  TrainState state = state_of(std::move(model));
  prune(state, scene);
  ASSERT_EQ(state.model.static_set.count(), 2);
  EXPECT_EQ(state.statistics[0].count[0], 0.0f);  // in front of the opaque one
  EXPECT_EQ(state.statistics[0].count[1], 1.0f);
}

// Bug put back: the first frames of the scene, which are those of the first cameras; seen to fail.
TEST(TrainUnseen, AShareOfTheFramesIsSpreadOverCamerasAndTimesteps) {
  const Scene scene = tiny_capture({.cameras = 8, .timesteps = 64, .size = 4});
  const std::vector<View> views = views_of_training(scene, 128).views;
  EXPECT_GE(views.size(), 128u);
  EXPECT_LT(views.size(), 256u);
  std::set<double> times;
  std::set<std::pair<double, double>> cameras;
  for (const View& view : views) {
    times.insert(view.time);
    cameras.insert({view.camera.cam_from_world[0][0], view.camera.cam_from_world[2][0]});
  }
  EXPECT_EQ(times.size(), 64u);
  EXPECT_EQ(cameras.size(), 8u);
}

/// A rig as long as real ones, without images, and Gaussians that live for some frames in it; three
/// cameras that stand side by side see each.
struct LongClip {
  Scene scene;
  GaussianModel model;
};

LongClip long_clip(int cameras, int timesteps, int64_t gaussians, double extent) {
  LongClip clip;
  for (int c = 0; c < cameras; ++c)
    for (int t = 0; t < timesteps; ++t) {
      Frame frame;
      const double angle = 2 * 3.14159265 * c / cameras;
      frame.camera = look_at({0, 0, 0}, {std::cos(angle), 0, std::sin(angle)}, 40, 30, 40);
      frame.camera_name = "cam" + std::to_string(100 + c);
      frame.time = double(t) / (timesteps - 1);
      frame.timestep = frame.frame_number = t;
      clip.scene.frames.push_back(frame);
    }
  Random random(7);
  GaussianSet& set = clip.model.dynamic_set = GaussianSet(SetForm::kVelocity, 1);
  clip.model.static_set = GaussianSet(SetForm::kStatic, 1);
  set.resize(gaussians);
  const GaussianSpans<float> v = set.values();
  for (int g = 0; g < set.groups(); ++g) std::fill_n(v.group[g].data, v.group[g].size, 0.0f);
  for (int64_t n = 0; n < gaussians; ++n) {
    const double angle = random.uniform(0, 2 * 3.14159265), far = random.uniform(3, 5);
    const double place[3] = {far * std::cos(angle), random.uniform(-1, 1), far * std::sin(angle)};
    for (int k = 0; k < 3; ++k) {
      v.at(kMean, n)[k] = float(place[k]);
      v.at(kLogScale, n)[k] = std::log(0.05f);
    }
    v.at(kRotation, n)[0] = 1;
    *v.at(kOpacityLogit, n) = logit(0.5f);
    *v.at(kMeanTime, n) = float(random.uniform(0, 1));
    *v.at(kLogScaleTime, n) = float(std::log(extent / (timesteps - 1)));
  }
  return clip;
}

/// Gaussians that `sampled` removes though a training view shows them, and those that it removes.
std::array<int64_t, 2> removals(const LongClip& clip, const SampledViews& sampled) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  Pipeline<float> pipeline(*backend);
  const GaussianModel& model = clip.model;
  const ForwardArgs<float> forward{
      {model.static_set.values(), model.dynamic_set.values()}, {}, render_options(model)};
  const auto largest = [&](const SampledViews& views) {
    return largest_weights(*backend, pipeline, forward, views, 4);
  };
  const Buffer<float> truth = largest(views_of_training(clip.scene, 1 << 30));
  const Buffer<float> found = largest(sampled);
  std::array<int64_t, 2> removed{};
  for (int64_t n = 0; n < found.size(); ++n) {
    const bool goes = found[n] >= 0 && found[n] < kLeast;
    removed[0] += goes && truth[n] >= kLeast;
    removed[1] += goes;
  }
  return removed;
}

// A clip as long as real ones is looked at in part. Bugs put back, each seen to fail: a Gaussian
// that no sampled view draws removed; whole sweeps of a frame sample in place of
// every n-th timestep, which leave a camera out for 48 timesteps in a row (5 %); the same timesteps
// of all cameras.
TEST(TrainUnseen, WhatSampledViewsDoNotShowIsNotKnown) {
  for (const double extent : {3.0, 0.8}) {
    LongClip clip = long_clip(20, 240, 3000, extent);
    for (const int64_t turn : {0, 1, 6}) {
      const SampledViews sampled = views_of_training(clip.scene, 1024, turn);
      EXPECT_FALSE(sampled.all);
      EXPECT_LT(sampled.views.size(), 1300u);
      EXPECT_LE(removals(clip, sampled)[0], 3) << extent << " " << turn;
    }
  }
  const LongClip sparse = long_clip(20, 240, 1000, 1);
  EXPECT_LT(removals(sparse, views_of_training(sparse.scene, 100))[0], 150)
      << "of some 700 not drawn";
  LongClip faint = long_clip(20, 240, 300, 3);
  for (int64_t n = 0; n < 300; ++n)
    faint.model.dynamic_set.group(kOpacityLogit).value[n] = logit(0.04f);
  EXPECT_GT(removals(faint, views_of_training(faint.scene, 1024))[1], 280);
  const LongClip brief = long_clip(20, 50, 300, 0.02);  // most live between two timesteps
  const SampledViews all = views_of_training(brief.scene, 1024);
  EXPECT_TRUE(all.all);
  EXPECT_GT(removals(brief, all)[1], 200) << "what no view of all shows goes";
}

// Bug put back: the first frames at every removal; seen to fail.
TEST(TrainUnseen, OtherFramesAreTakenAtEachRemoval) {
  const LongClip clip = long_clip(20, 240, 1, 3);
  std::set<std::pair<double, double>> taken;
  for (int64_t turn = 0; turn < 4; ++turn)
    for (const View& view : views_of_training(clip.scene, 1024, turn).views)
      EXPECT_TRUE(taken.insert({view.camera.cam_from_world[0][0], view.time}).second) << turn;
  EXPECT_EQ(taken.size(), 4800u);
}

TrainOptions pruning_options() {
  TrainOptions options = tiny_options();
  options.min_blending_weight = kLeast;
  options.unseen_interval = 10;
  options.densify_from = 10;
  options.opacity_reset_interval = 0;
  return options;
}

TEST(TrainUnseen, ATrainingRemovesThemBetweenItsSteps) {
  const Scene scene = tiny_capture();
  TrainOptions options = pruning_options();
  options.densify_until = 0;  // no other reason to go
  TrainState state = first_state(scene, options);
  GaussianSet& set = state.set(state.model.static_set.count() > 0 ? 0 : 1);
  set_value(set, kMean, 0, {0, 50, 0});
  const int64_t before = state.model.count();
  Training training(scene, options, state.clone_to(host_memory()));
  training.run(10);
  EXPECT_EQ(training.model().count(), before);
  training.run(11);
  EXPECT_LT(training.model().count(), before);
  int64_t reported = 0;
  for (const DensityReport& report : training.density()) reported += report.pruned;
  EXPECT_EQ(reported, before - training.model().count());

  options.min_blending_weight = 0;
  Training without(scene, options, std::move(state));
  EXPECT_EQ(without.run(11).model().count(), before);
}

TEST(TrainUnseen, AResumedTrainingIsTheSame) {
  const Scene scene = tiny_capture();
  const TrainOptions options = pruning_options();
  Training whole(scene, options);
  whole.run(25);
  Training first(scene, options);
  first.run(10);
  Training second(scene, options, first.trainer().host_state().clone_to(host_memory()));
  second.run(25);
  EXPECT_EQ(state_bits(second.state()), state_bits(whole.state()));
}

}  // namespace
}  // namespace tessera::testing
