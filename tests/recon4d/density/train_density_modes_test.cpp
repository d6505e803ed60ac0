// Effects of density control on a whole training: a reset of opacities, Gaussians that no camera
// sees, a wall without texture. Source: failure modes C11, C12, C19.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/pipeline.h"
#include "recon4d/density/density.h"
#include "recon4d/evaluation/render.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

TrainOptions quick_options() {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = 300;
  options.densify_from = 40;
  options.densify_until = 280;
  options.densify_interval = 20;
  options.init_points = 120;
  return options;
}

// C11: a reset costs decibels at once and none 60 steps later; no Gaussian falls to it.
// Bug put back: reset to 0.001, below what is pruned; seen to fail (all are pruned).
TEST(DensityModes, AResetOfOpacityIsMadeUpFor) {
  const Scene scene = tiny_capture();
  TrainOptions options = quick_options();
  options.opacity_reset_interval = 200;
  Training training(scene, options);
  const double before = training.run(200).psnr();
  const int64_t count = training.model().count();
  EXPECT_LT(training.run(201).psnr(), before - 3);
  EXPECT_GE(training.run(260).psnr(), before - 0.1);
  EXPECT_GE(training.model().count(), count);
}

/// Σ T·α of each Gaussian over all pixels of the views, first the static set's: dL/dSH₀ of
/// L = Σ colour, as grey Gaussians' colours are clamped nowhere.
std::vector<double> blending_weights(const GaussianModel& model, const std::vector<Frame>& frames) {
  GaussianModel grey = model.clone_values();
  for (GaussianSet* set : {&grey.static_set, &grey.dynamic_set})
    std::fill(set->group(kSh).value.begin(), set->group(kSh).value.end(), 0.0f);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  Pipeline<float> pipeline(*backend);
  std::vector<double> weights(size_t(model.count()), 0.0);
  for (const Frame& frame : frames) {
    GaussianModel gradient = grey.clone_values();
    const GaussianModel& in = grey;
    pipeline.forward(in.static_set.values(), in.dynamic_set.values(),
                     {View{frame.camera, frame.time}}, render_options(in), true);
    Target target;
    target.truth.emplace_back(frame.image.data.data(), int64_t(frame.image.data.size()));
    pipeline.loss(target, true);
    std::fill(pipeline.d_colour().begin(), pipeline.d_colour().end(), 1.0f);
    SetStatistics statistics[2];
    BackwardArgs<float> args;
    for (int k = 0; k < 2; ++k) {
      GaussianSet& set = k == 0 ? gradient.static_set : gradient.dynamic_set;
      statistics[k].reset(set.count());
      args.sinks[k].gradient = set.values();
      args.statistics[k] = statistics[k].spans();
    }
    pipeline.backward(args);
    size_t i = 0;
    for (const GaussianSet* set : {&gradient.static_set, &gradient.dynamic_set})
      for (int64_t n = 0; n < set->count(); ++n) weights[i++] += *set->values().at(kSh, n) / kSh0;
  }
  return weights;
}

/// Without those whose weight is 0.
GaussianModel without_unseen(const GaussianModel& model, const std::vector<double>& weights) {
  GaussianModel kept = model.clone_values();
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  size_t i = 0;
  for (GaussianSet* set : {&kept.static_set, &kept.dynamic_set}) {
    std::vector<int64_t> elements;
    for (int64_t n = 0; n < set->count(); ++n)
      if (weights[i++] != 0) elements.push_back(n);
    const Span<const int64_t> all(elements.data(), int64_t(elements.size()));
    take_elements(*backend, all, all, *set);
  }
  return kept;
}

/// Largest difference of a value of two models' images of frames.
double largest_difference(const GaussianModel& a, const GaussianModel& b,
                          const std::vector<Frame>& frames) {
  std::vector<View> views;
  for (const Frame& frame : frames) views.push_back({frame.camera, frame.time});
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const std::vector<RenderedImage> left = render_views(*backend, a, views),
                                   right = render_views(*backend, b, views);
  double largest = 0;
  for (size_t i = 0; i < left.size(); ++i)
    for (size_t p = 0; p < left[i].rgb.size(); ++p)
      largest = std::max(largest, std::abs(double(left[i].rgb[p]) - right[i].rgb[p]));
  return largest;
}

// C12: Gaussians that no training image of any timestep shows can be removed, and images stay equal
// to the bit; those that one timestep does not show cannot. A held-out camera may see some that
// were just too faint for the others, each α of 1/255 times its colour, and more than one at a
// pixel (1.50/255 on one CPU, less on others); the failure mode's 1e-4 holds where α has no such
// threshold.
TEST(DensityModes, OnlyWhatNoTimestepShowsIsRemoved) {
  TinyCapture capture{.timesteps = 6};
  Scene scene = tiny_capture(capture);
  const std::vector<Frame> held_out(scene.frames.end() - capture.timesteps, scene.frames.end());
  scene.frames.resize(scene.frames.size() - held_out.size());
  std::vector<Frame> first;
  for (const Frame& frame : scene.frames)
    if (frame.time == 0) first.push_back(frame);
  TrainOptions options = quick_options();
  options.init_time_scale = 0.05;
  Training training(scene, options);
  const GaussianModel model = training.run().model().clone_values();

  const GaussianModel kept = without_unseen(model, blending_weights(model, scene.frames));
  EXPECT_LT(kept.count(), 0.9 * double(model.count()));
  EXPECT_EQ(largest_difference(model, kept, scene.frames), 0);
  EXPECT_LT(largest_difference(model, kept, held_out), 3.0 / 255);
  const GaussianModel wrong = without_unseen(model, blending_weights(model, first));
  EXPECT_GT(largest_difference(model, wrong, scene.frames), 0.05);
}

// C19: a wall without texture that fills all images: nothing calls for more Gaussians, and they
// do not flicker. With prune_extent as of 3DGS what is large and right is removed and its place
// filled by small ones: 300 → 2,070 were seen, so it is off here.
// Bug put back: densify_threshold 0; seen to fail.
TEST(DensityModes, AWallWithoutTextureStaysAsItIs) {
  const TinyCapture capture;
  GaussianModel nothing = tiny_truth(capture);
  nothing.static_set.resize(0);
  nothing.dynamic_set.resize(0);
  nothing.background = {128, 128, 128};
  Scene scene = tiny_capture(capture, nothing);
  scene.background = {0, 0, 0};
  scene.had_alpha = false;
  TrainOptions options;
  options.iterations = 400;
  options.batch = 2;
  options.densify_interval = 20;
  options.init_points = 300;
  options.static_fraction = 0.5;
  options.prune_extent = 0;
  Training training(scene, options);
  EXPECT_GT(training.run().psnr(), 45);
  EXPECT_LE(training.model().count(), 1.2 * 300);

  std::vector<View> views;
  constexpr int kMoments = 9;
  for (int i = 0; i < kMoments; ++i)
    views.push_back({scene.frames[0].camera, i / double(kMoments - 1)});
  const std::vector<RenderedImage> film = render_views(training.backend(), training.model(), views);
  double largest = 0;  // standard deviation of a value over time
  for (size_t p = 0; p < film[0].rgb.size(); ++p) {
    double sum = 0, squares = 0;
    for (const RenderedImage& image : film) sum += image.rgb[p];
    for (const RenderedImage& image : film) squares += std::pow(image.rgb[p] - sum / kMoments, 2);
    largest = std::max(largest, std::sqrt(squares / kMoments));
  }
  EXPECT_LT(largest, 0.5 / 255);  // 0.11/255 was seen
}

/// Σ of the mean gradients of those of a set that may grow.
double weight_of(const GaussianSet& set, const SetStatistics& statistics,
                 const TrainOptions& options) {
  double weight = 0;
  for (int64_t n = 0; n < set.count(); ++n) {
    if (statistics.count[n] == 0) continue;
    const double score = statistics.gradient_sum[n] / statistics.count[n];
    const double logit = *set.values().at(kOpacityLogit, n);
    if (score >= options.densify_threshold && 1 / (1 + std::exp(-logit)) >= options.prune_opacity)
      weight += score;
  }
  return weight;
}

/// Growth by a budget up to `limit`; what has any gradient to speak of may grow.
TrainOptions budget_options(int64_t limit, double threshold) {
  TrainOptions options = quick_options();
  options.densification = Densification::kBudget;
  options.densify_threshold = threshold;
  options.max_gaussians = limit;
  return options;
}

// Bugs put back, seen to fail: the share of the static set by its count; no share of the budget.
TEST(DensityModes, ADrawSharesTheBudgetByTheScoresOfBothSets) {
  const Scene scene = tiny_capture();
  TrainOptions options = budget_options(160, 1e-5);
  options.static_fraction = 0.5;
  options.prune_opacity = 1e-4;  // nothing is removed: that would make room in its set
  options.prune_extent = 0;
  Training training(scene, options);
  training.run(40);
  const TrainState& state = training.state();
  const int64_t before = state.model.count();
  const double fixed = weight_of(state.model.static_set, state.statistics[0], options);
  const double moving = weight_of(state.model.dynamic_set, state.statistics[1], options);
  // the first of 13 controls, at 40, 60 … 280
  const int64_t room = std::llround(std::sqrt(1.0 / 13) * double(160 - before));
  training.run(41);
  ASSERT_EQ(training.density().size(), 2u);
  const DensityReport &of_static = training.density()[0], &of_dynamic = training.density()[1];
  EXPECT_EQ(of_static.cloned + of_dynamic.cloned, 0);
  EXPECT_NEAR(double(of_static.split - of_static.pruned), fixed / (fixed + moving) * double(room),
              1.01);
  EXPECT_EQ(of_static.after + of_dynamic.after, before + room);
  EXPECT_GT(std::abs(fixed / (fixed + moving) - double(of_static.before) / double(before)), 0.05)
      << "not by their counts";
}

// Bug put back: the control at the end leaves a share of the room; seen to fail.
TEST(DensityModes, TheBudgetIsFilledInTheEndAndASeedGivesTheSameBits) {
  const Scene scene = tiny_capture();
  TrainOptions options = budget_options(300, 1e-7);
  Training first(scene, options), second(scene, options);
  const std::vector<uint32_t> bits = model_bits(first.run(290).model());
  EXPECT_EQ(first.model().count(), 300);
  EXPECT_EQ(model_bits(second.run(290).model()), bits);
  options.seed = 2;
  Training other(scene, options);
  EXPECT_NE(model_bits(other.run(290).model()), bits);
}

}  // namespace
}  // namespace tessera::testing
