// MCMC densification on sets made by hand, and trainings with it: exact counts, attributes of
// copies, the size of the noise, and equality after a resume. The choice and images of n copies are
// tested in tests/kernels/relocation_test.cpp.
#include "recon4d/density/mcmc.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"
#include "kernels/math/relocation.h"
#include "recon4d/options/presets.h"
#include "recon4d/training/schedule.h"
#include "tests/recon4d/model/handmade_set.h"
#include "tests/support/separate_backend.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

/// Static and dynamic set in which every `dead_every`-th Gaussian is dead.
TrainState handmade_state(int64_t fixed, int64_t moving, int64_t dead_every = 1000) {
  TrainState state;
  for (int k = 0; k < 2; ++k) {
    HandmadeSet made(k == 0 ? SetForm::kStatic : SetForm::kPair, k == 0 ? fixed : moving);
    for (int64_t n = 0; n < made.set.count(); ++n)
      made.describe(n, 0.1f, n % dead_every == dead_every - 1 ? 0.004f : 0.2f + 0.1f * float(n % 5),
                    0);
    state.set(k) = std::move(made.set);
    state.statistics[k].reset(state.set(k).count());
  }
  state.iteration = 700;
  return state;
}

TrainOptions mcmc_options(int64_t limit) {
  TrainOptions options;
  options.densification = Densification::kMcmc;
  options.max_gaussians = limit;
  return options;
}

std::array<DensityReport, 2> control(TrainState& state, const TrainOptions& options) {
  return control_mcmc(*make_cpu_backend(), options, state);
}

// Failure mode C13: exact counts.
// Bug put back: the limit left out; seen to fail.
TEST(Mcmc, GrowsByItsFactorAndToExactlyTheLimit) {
  EXPECT_EQ(grown_count(100, 1.05, 1000), 105);
  EXPECT_EQ(grown_count(119, 1.05, 1000), 124) << "124.95";
  EXPECT_EQ(grown_count(19, 1.05, 1000), 19) << "19.95";
  EXPECT_EQ(grown_count(990, 1.05, 1000), 1000);
  EXPECT_EQ(grown_count(1000, 1.05, 1000), 1000);
  EXPECT_EQ(grown_count(1200, 1.05, 1000), 1200) << "nothing is removed";
  EXPECT_EQ(grown_count(1000, 1, 2000), 1000);
  EXPECT_EQ(grown_count(4000000000, 1e6, 5000000000), 5000000000);
  TrainState state = handmade_state(60, 40);
  TrainOptions options = mcmc_options(131);
  const int64_t counts[] = {105, 110, 115, 120, 126, 131, 131};
  for (const int64_t expected : counts) {
    const auto reports = control(state, options);
    EXPECT_EQ(state.model.count(), expected);
    EXPECT_EQ(reports[0].added + reports[1].added,
              reports[0].after + reports[1].after - reports[0].before - reports[1].before);
    for (int k = 0; k < 2; ++k) {
      EXPECT_EQ(reports[size_t(k)].after, state.set(k).count());
      EXPECT_EQ(state.statistics[k].count.size(), state.set(k).count());
    }
  }
}

TEST(Mcmc, WhatIsAddedIsSharedByOpacity) {
  // Bug put back: shared by counts; seen to fail.
  EXPECT_EQ(shares_of(10, {3, 1}), (std::array<int64_t, 2>{8, 2}));  // 7.5
  EXPECT_EQ(shares_of(7, {0, 5}), (std::array<int64_t, 2>{0, 7}));
  EXPECT_EQ(shares_of(7, {5, 0}), (std::array<int64_t, 2>{7, 0}));
  EXPECT_EQ(shares_of(7, {0, 0}), (std::array<int64_t, 2>{0, 0})) << "no Gaussian to copy";
  TrainState state = handmade_state(100, 100);
  for (float& logit : state.model.static_set.group(kOpacityLogit).value) logit = 0;  // 0.5
  for (float& logit : state.model.dynamic_set.group(kOpacityLogit).value) logit = -2.944439f;
  TrainOptions options = mcmc_options(1000);
  options.mcmc_growth = 1.11;
  const auto reports = control(state, options);  // 0.5 and 0.05: ten to one
  EXPECT_EQ(reports[0].added, 20);
  EXPECT_EQ(reports[1].added, 2);
}

TEST(Mcmc, TheDeadBecomeCopiesAndKeepTheirMoments) {
  // Bugs put back, each seen to fail: the dead lose their moments; sources keep theirs; a group of
  // the dynamic set is not copied.
  TrainState state = handmade_state(50, 60, 5);
  const TrainState before = state.clone_to(host_memory());
  TrainOptions options = mcmc_options(110);  // no growth
  const auto reports = control(state, options);
  EXPECT_EQ(reports[0].relocated, 10);
  EXPECT_EQ(reports[1].relocated, 12);
  EXPECT_EQ(state.model.count(), 110);
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    const GaussianSet& old = before.set(k);
    std::vector<int64_t> source(size_t(set.count()));
    std::vector<int> copies(size_t(set.count()), 1);
    for (int64_t n = 0; n < set.count(); ++n) {  // the tag identifies the Gaussian
      source[size_t(n)] = int64_t(*set.values().at(kSh, n));
      EXPECT_EQ(source[size_t(n)] != n, n % 5 == 4) << n;
      if (n % 5 == 4) ++copies[size_t(source[size_t(n)])];
    }
    for (int64_t n = 0; n < set.count(); ++n) {
      const int64_t s = source[size_t(n)];
      const int count = copies[size_t(s)];
      EXPECT_NE(s % 5, 4) << "a dead one was copied";
      const Relocated r = relocated(sigmoid(double(*old.values().at(kOpacityLogit, s))), count);
      for (int g = 0; g < set.groups(); ++g) {
        const int width = set.width(Group(g));
        const ParameterGroup &now = set.group(Group(g)), &then = old.group(Group(g));
        for (int j = 0; j < width; ++j) {
          double expected = then.value[s * width + j];
          if (count > 1 && g == kOpacityLogit)
            expected = std::log(r.opacity / (1 - r.opacity));
          else if (count > 1 && (g == kLogScale || g == kLogScaleTime))
            expected += std::log(r.scale);
          EXPECT_NEAR(now.value[n * width + j], expected, 1e-6) << group_name(Group(g), set.form());
          const bool zeroed = s == n && count > 1;
          EXPECT_EQ(now.moment1[n * width + j], zeroed ? 0 : then.moment1[n * width + j]);
          if (packs_moments(Group(g))) continue;
          EXPECT_EQ(now.moment2[n * width + j], zeroed ? 0 : then.moment2[n * width + j]);
        }
      }
    }
  }
}

TEST(Mcmc, WhatIsAddedHasNoMoments) {
  TrainState state = handmade_state(100, 0);
  control(state, mcmc_options(105));
  const ParameterGroup& mean = state.model.static_set.group(kMean);
  for (int64_t i = 3 * 100; i < 3 * 105; ++i) EXPECT_EQ(mean.moment1[i] + mean.moment2[i], 0);
  int zeroed = 0;
  for (int64_t n = 0; n < 100; ++n) zeroed += mean.moment1[3 * n] == 0;
  EXPECT_GE(zeroed, 1);
  EXPECT_LE(zeroed, 5) << "the sources";
}

// Bug put back: a set of dead Gaussians is relocated; seen to fail.
TEST(Mcmc, SetsOfDeadGaussians) {
  TrainState state = handmade_state(30, 40, 1);  // all dead
  try {
    control(state, mcmc_options(1000));
    ADD_FAILURE() << "went on";
  } catch (const NumericalError& error) {
    EXPECT_NE(std::string(error.what()).find("step 700"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("--init-opacity 0.5"), std::string::npos);
  }
  state = handmade_state(0, 0);
  EXPECT_EQ(control(state, mcmc_options(1000))[0].added, 0) << "nothing to lose";
  state = handmade_state(30, 40, 1);  // the static set is empty at the end, the dynamic one grows
  for (float& logit : state.model.dynamic_set.group(kOpacityLogit).value) logit = 0;
  EXPECT_EQ(control(state, mcmc_options(1000))[1].added, 3);
  EXPECT_EQ(state.model.static_set.count(), 30);
  state = handmade_state(0, 40, 2);
  const auto reports = control(state, mcmc_options(1000));
  EXPECT_EQ(reports[0].added, 0);
  EXPECT_EQ(reports[1].relocated, 20);
  EXPECT_EQ(reports[1].added, 2);
}

TEST(McmcOptions, NeedALimitAndNoResets) {
  const auto refusal = [](const TrainOptions& options) -> std::string {
    try {
      validate(options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(mcmc_options(5)), "");
  EXPECT_NE(refusal(mcmc_options(0)).find("--max-gaussians"), std::string::npos);
  TrainOptions options = mcmc_options(5);
  options.opacity_reset_interval = 3000;
  EXPECT_NE(refusal(options).find("--opacity-reset-interval 0"), std::string::npos);
}

TEST(McmcOptions, ThePresetIsTheMethods) {
  TrainOptions options;
  apply_preset(options, "mcmc");
  const Schedule schedule(options, 2.5);
  int64_t first = -1, last = -1, count = 0, resets = 0, gathered = 0;
  for (int64_t i = 0; i < options.iterations; ++i) {
    resets += schedule.reset_opacity(i);
    gathered += schedule.gathers_statistics(i);
    if (!schedule.densify(i)) continue;
    first = first < 0 ? i : first;
    last = i;
    ++count;
  }
  EXPECT_EQ(first, 600);
  EXPECT_EQ(last, 24900);
  EXPECT_EQ(count, 244);
  EXPECT_EQ(resets + gathered, 0);
  EXPECT_TRUE(schedule.reorder(25000));
  EXPECT_EQ(options.motion, Motion::kNone);
  EXPECT_EQ(options.init_opacity, 0.5);
  EXPECT_EQ(options.init_scale_factor, 0.1);
  // 5e5·η_μ, whose first is 1.6e-4·E and whose last a hundredth of it
  EXPECT_NEAR(schedule.noise_scale(29999), 5e5 * 1.6e-6 * 2.5, 1e-9);
  EXPECT_NEAR(schedule.noise_scale(14999), 5e5 * 1.6e-5 * 2.5, 1e-9);
  EXPECT_EQ(Schedule({}, 2.5).noise_scale(10), 0) << "adc has none";
}

// Bug put back: squared distances by the factor; seen to fail.
TEST(McmcOptions, TheScaleFactorIsOfDistances) {
  const Scene scene = tiny_capture();
  TrainOptions options = tiny_options();
  const TrainState usual = first_state(scene, options);
  options.init_scale_factor = 0.1;
  const TrainState small = first_state(scene, options);
  for (int k = 0; k < 2; ++k)
    for (int64_t i = 0; i < 3 * usual.set(k).count(); ++i)
      EXPECT_NEAR(small.set(k).group(kLogScale).value[i],
                  usual.set(k).group(kLogScale).value[i] + std::log(0.1), 1e-6);
}

/// The tiny capture's, with both sets, a limit that is reached, and noise for its short time.
TrainOptions tiny_mcmc() {
  TrainOptions options = tiny_options();
  options.densification = Densification::kMcmc;
  options.max_gaussians = 90;
  options.mcmc_growth = 1.15;
  options.opacity_weight = options.scale_weight = 0.01;
  return options;
}

// Failure mode C13. Bug put back: growth by one set's count; seen to fail.
TEST(McmcTraining, ReachesTheLimitExactlyAndKeepsIt) {
  const Scene scene = tiny_capture();
  Training training(scene, tiny_mcmc());
  training.run(39);
  const int64_t first = training.steps().front().num_static + training.steps().front().num_dynamic;
  EXPECT_LT(first, 90);
  for (const StepReport& step : training.steps())
    EXPECT_EQ(step.num_static + step.num_dynamic,
              step.iteration <= 6    ? first
              : step.iteration <= 12 ? int64_t(1.15 * double(first))
              : step.iteration <= 18 ? int64_t(1.15 * double(int64_t(1.15 * double(first))))
                                     : 90)
        << step.iteration;
  for (const DensityReport& report : training.density())
    EXPECT_EQ(report.cloned + report.split + report.pruned, 0);
}

// Bug put back: the noise named by the steps of this trainer; seen to fail.
TEST(McmcTraining, ResumeEqualsAnUninterruptedTraining) {
  const Scene scene = tiny_capture();
  Training whole(scene, tiny_mcmc());
  whole.run();
  for (const int64_t pause : {6, 17}) {
    Training first(scene, tiny_mcmc());
    first.run(pause);
    TrainState state = first.state().clone_to(host_memory());
    Training second(scene, tiny_mcmc(), std::move(state));
    EXPECT_EQ(state_bits(second.run().state()), state_bits(whole.state())) << pause;
  }
  set_thread_count(3);
  Training threaded(scene, tiny_mcmc());
  EXPECT_EQ(state_bits(threaded.run().state()), state_bits(whole.state()));
  set_thread_count(0);
}

// Bug put back: a span of the host handed to the noise; seen to fail.
TEST(McmcTraining, StaysInTheBackendsMemory) {
  const Scene scene = tiny_capture();
  SeparateBackend backend;
  Training training(scene, tiny_mcmc(), first_state(scene, tiny_mcmc()), backend);
  training.run(20);
  EXPECT_EQ(backend.strays, 0);
  Training plain(scene, tiny_mcmc());
  plain.run(20);
  EXPECT_EQ(model_bits(training.state().clone_to(host_memory()).model), model_bits(plain.model()));
}

// Seeds 1 to 8: 3.0, 8.2, 5.3, 5.8, 4.0, 6.0, 4.0 and 9.3 dB. Bug put back: means without noise;
// seen to fail.
TEST(McmcTraining, BeatsASetThatDoesNotGrow) {
  // From 20 points: 40 that were placed by the chain, and 20 that were not.
  const Scene scene = tiny_capture();
  TrainOptions options = tiny_mcmc();
  options.iterations = options.schedule_iterations = 400;
  options.init_points = 20;
  options.max_gaussians = 60;
  options.init_opacity = 0.5;
  options.mcmc_noise = 5e3;  // means are trained for 400 steps, not 30,000
  std::vector<double> gains;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    options.densify_until = 330;
    Training grown(scene, options);
    options.densify_until = 0;
    Training still(scene, options);
    grown.run();
    still.run();
    EXPECT_EQ(grown.steps().back().num_static + grown.steps().back().num_dynamic, 60);
    gains.push_back(grown.psnr() - still.psnr());
  }
  EXPECT_GT(median(gains), 3);
}

}  // namespace
}  // namespace tessera::testing
