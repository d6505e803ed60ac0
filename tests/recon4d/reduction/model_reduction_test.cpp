// What: when a training decides what it needs no more of, how many Gaussians are left then, and
//       that a resumed training decides as one that was never stopped.
// Not: what decides (contributions_test.cpp, pruning_test.cpp, static_demotion_test.cpp,
// dynamic_promotion_test.cpp). Source: failure modes C13, E5.
#include "recon4d/reduction/model_reduction.h"

#include <gtest/gtest.h>

#include "recon4d/model/checkpoint.h"
#include "recon4d/model/sh_blocks.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/separate_backend.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

int64_t made_bytes(const GaussianModel& model) {
  return 100 + 40 * model.static_set.count() + 60 * model.dynamic_set.count();
}

/// Grows until 100, thins out at 101, 127, 153 and 180, decides on motion at 30, 60 and 90.
TrainOptions thrifty_options() {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = 200;
  options.init_points = 150;
  options.static_fraction = 0.4;
  options.sh_degree = 2;
  options.sh_interval = 20;
  options.sh_time_degree = 0;
  options.densify_from = 10;
  options.densify_until = 100;
  options.densify_interval = 15;
  options.densify_threshold = 5e-5;
  options.peak_gaussians = 260;
  options.size = ModelSize::kKnee;
  options.decide_motion = true;
  options.decide_colour = true;
  options.thin_rounds = 4;
  options.thin_until = 180;
  options.decide_interval = 30;
  return options;
}

std::vector<int64_t> steps_of(const Backend& backend, const TrainOptions& options) {
  const ModelReduction reduction(const_cast<Backend&>(backend), options, made_bytes);
  std::vector<int64_t> steps;
  for (int64_t i = reduction.next_after(0); i < 1000000; i = reduction.next_after(i))
    steps.push_back(i);
  return steps;
}

// Bug put back: thin_until not scaled with the schedule; seen to fail.
TEST(ModelReduction, DecidesAtItsSteps) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  using Steps = std::vector<int64_t>;
  TrainOptions options = thrifty_options();
  EXPECT_EQ(steps_of(*backend, options), (Steps{30, 60, 90, 101, 127, 153, 180}));
  options.motion = Motion::kNone;
  EXPECT_EQ(steps_of(*backend, options), (Steps{101, 127, 153, 180}));
  options.motion = Motion::kPair;
  options.decide_motion = false;
  options.thin_rounds = 1;
  EXPECT_EQ(steps_of(*backend, options), (Steps{101}));
  options.size = ModelSize::kGrown;
  EXPECT_EQ(steps_of(*backend, options), Steps{});
  EXPECT_TRUE(ModelReduction(*backend, options, made_bytes).has_pruned(0));
  for (const auto& [key, value] : {std::pair<const char*, OptionValue>{"max_bytes", 9},
                                   {"within_db", 0.5},
                                   {"max_gaussians", 100}}) {
    TrainOptions asked = options;
    set_option(asked, key, value);
    EXPECT_EQ(steps_of(*backend, asked), (Steps{101})) << key;
  }
  options = thrifty_options();
  options.iterations = 100;  // half of the schedule
  EXPECT_EQ(steps_of(*backend, options), (Steps{15, 30, 45, 51, 64, 77, 90}));
  options = thrifty_options();
  options.thin_until = 400;
  EXPECT_EQ(steps_of(*backend, options), (Steps{30, 60, 90, 101})) << "those before the end";
  const ModelReduction reduction(*backend, thrifty_options(), made_bytes);
  for (int64_t i : {0, 101, 179}) EXPECT_FALSE(reduction.has_pruned(i)) << i;
  for (int64_t i : {180, 200}) EXPECT_TRUE(reduction.has_pruned(i)) << i;
}

/// A training with its decisions, from its beginning or from a state.
struct Thrifty {
  Scene scene;
  std::unique_ptr<Training> training;
  std::unique_ptr<Validation> validation;
  std::unique_ptr<ModelReduction> reduction;

  explicit Thrifty(const TrainOptions& options, std::optional<Checkpoint> from = {},
                   Backend* backend = nullptr)
      : scene(tiny_capture()) {
    hold_out_validation(scene, options.validation_share, 1);
    TrainState state = from ? std::move(from->state) : first_state(scene, options);
    training = backend != nullptr
                   ? std::make_unique<Training>(scene, options, std::move(state), *backend)
                   : std::make_unique<Training>(scene, options, std::move(state));
    validation = std::make_unique<Validation>(training->backend(), scene, options,
                                              from ? from->validation : ValidationRecord{});
    reduction = std::make_unique<ModelReduction>(training->backend(), options, made_bytes);
  }
  Thrifty& run(int64_t iteration) {
    training->run(iteration, *reduction, *validation);
    return *this;
  }
  Checkpoint saved() const {
    const ScratchFolder folder;
    save_checkpoint(folder / "half.ckpt", training->trainer().host_state(),
                    training->trainer().options(), {}, validation->record());
    return load_checkpoint(folder / "half.ckpt");
  }
  const std::vector<ReductionReport>& decisions() const { return training->decisions(); }
};

// Bug put back: the goal found anew at every round; seen to fail.
TEST(ModelReduction, TheLastRoundLeavesTheKneeOfTheFirst) {
  const Thrifty run = std::move(Thrifty(thrifty_options()).run(180));
  ASSERT_EQ(run.decisions().size(), 7u);
  int64_t goal = 0;
  for (const ReductionReport& report : run.decisions()) {
    const bool thins = report.iteration > 100;
    EXPECT_EQ(report.goal > 0, thins) << report.iteration;
    EXPECT_EQ(report.static_before + report.dynamic_before + report.spawned - report.removed,
              report.static_after + report.dynamic_after);
    EXPECT_GT(report.psnr, 0);
    if (thins && goal == 0) goal = report.knee;
    if (thins) {
      EXPECT_EQ(report.goal, goal) << report.iteration;
    }
    EXPECT_EQ(report.sampled_frames, 24) << "too few for sweeps";
  }
  const TrainState& state = run.training->state();
  EXPECT_EQ(state.model.count(), goal);
  EXPECT_EQ(state.goal, goal);
  EXPECT_LT(goal, run.decisions()[3].static_before + run.decisions()[3].dynamic_before);
  const ReductionReport& last = run.decisions().back();
  EXPECT_EQ(last.degrees[0] + last.degrees[1] + last.degrees[2] + last.degrees[3], goal);
  std::array<int64_t, 4> degrees{};
  for (int k = 0; k < 2; ++k)
    for (const uint8_t d : sh_degrees(state.set(k))) ++degrees[d];
  EXPECT_EQ(degrees, last.degrees);
  EXPECT_GT(degrees[0], 0) << "some need one colour";
  EXPECT_EQ(degrees[3], 0) << "of two bands";
}

// C13. Bug put back: the goal without its spare; seen to fail.
TEST(ModelReduction, TheLastRoundLeavesALittleMoreThanIsAskedFor) {
  TrainOptions options = thrifty_options();
  options.max_gaussians = 80;
  EXPECT_EQ(Thrifty(options).run(180).training->model().count(), 83) << "1.04 of it";
  options.max_gaussians = 0;
  options.max_bytes = 5000;
  options.decide_motion = false;
  const int64_t bytes = made_bytes(Thrifty(options).run(180).training->model());
  EXPECT_NEAR(double(bytes), 5200, 199) << "what is left differs from what went";
}

// Bug put back: 1 dB, whatever was asked for; seen to fail.
TEST(ModelReduction, AFewDecibelsAreTakenFromWhatTheImagesPredict) {
  TrainOptions options = thrifty_options();
  options.decide_motion = false;
  options.validation_share = 0.2;
  options.validate_interval = 20;
  const auto left = [&](double decibels) {
    options.within_db = decibels;
    const Thrifty run = std::move(Thrifty(options).run(101));
    const ReductionReport& first = run.decisions().front();
    EXPECT_GT(first.removed, 0) << decibels;
    return first.goal;
  };
  const int64_t near = left(0.2), far = left(3);
  EXPECT_LT(far, near);
}

// Bug put back: `decided` not looked at; seen to fail.
TEST(ModelReduction, DecidesOnceAtAStepAlsoAfterAResume) {
  Thrifty run = std::move(Thrifty(thrifty_options()).run(101));
  ASSERT_EQ(run.decisions().size(), 4u);
  EXPECT_EQ(run.training->state().decided, 101);
  EXPECT_FALSE(run.reduction->act(run.training->trainer(), {}).has_value());
  Checkpoint half = run.saved();
  EXPECT_EQ(half.state.decided, 101);
  EXPECT_EQ(half.state.goal, run.decisions().back().knee);
  Thrifty again(thrifty_options(), std::move(half));
  EXPECT_FALSE(again.reduction->act(again.training->trainer(), {}).has_value());
  EXPECT_EQ(again.training->model().count(), run.training->model().count());
  // stopped at the step but before the decision it is made up for
  Thrifty undecided(thrifty_options());
  undecided.run(100).training->run(101);
  Thrifty late(thrifty_options(), undecided.saved());
  ASSERT_TRUE(late.reduction->act(late.training->trainer(), {}).has_value());
  EXPECT_TRUE(state_bits(late.training->state()) == state_bits(run.training->state()));
}

// Bug put back: images of the host handed to the stages; seen to fail.
TEST(ModelReduction, IsTheSameInAMemoryOfItsOwn) {
  const Thrifty here = std::move(Thrifty(thrifty_options()).run(200));
  testing::SeparateBackend backend;
  Thrifty separate(thrifty_options(), {}, &backend);
  separate.run(200);
  EXPECT_GT(here.training->model().static_set.count(), 0);
  EXPECT_TRUE(state_bits(separate.training->state().clone_to(host_memory())) ==
              state_bits(here.training->state()));
  EXPECT_EQ(backend.strays, 0);
}

// E5. Bug put back: the goal not read from the checkpoint; seen to fail.
TEST(ModelReduction, ResumeGoesOnBitForBit) {
  for (const IdleUpdate updates : {IdleUpdate::kDense, IdleUpdate::kSkip}) {
    TrainOptions options = thrifty_options();
    options.idle_updates = updates;
    const Thrifty whole = std::move(Thrifty(options).run(200));
    EXPECT_TRUE(whole.training->state().has_blocks());
    for (const int64_t half : {100, 140, 190}) {
      const Thrifty first = std::move(Thrifty(options).run(half));
      const Thrifty second = std::move(Thrifty(options, first.saved()).run(200));
      EXPECT_TRUE(state_bits(second.training->state()) == state_bits(whole.training->state()))
          << name_of(updates) << " from " << half;
    }
  }
}

// On a device sums are in a fixed order only where that is asked for. Bug put back: decisions
// looked with the kernels' own switches, so that no training with them could be repeated; seen to
// fail.
TEST(ModelReduction, LooksWithTheKernelsOfTheTraining) {
  TrainOptions options = thrifty_options();
  for (const bool deterministic : {false, true}) {
    options.deterministic = deterministic;
    const Thrifty run(options);
    EXPECT_EQ(run.training->trainer().sample_frames().kernels.deterministic, deterministic);
  }
}

// Density control may have removed them all. Bug put back: thinned like any other; seen to fail,
// by never coming back.
TEST(ModelReduction, NoGaussiansAreNothingToThin) {
  TrainOptions options = thrifty_options();
  options.max_gaussians = 50;
  Thrifty run(options);
  run.run(100);
  run.training->trainer().edit([](TrainState& state) {
    for (int k = 0; k < 2; ++k) {
      state.set(k).resize(0);
      state.set(k).ensure_moments();
      state.statistics[k].reset(0);
    }
  });
  run.run(200);
  EXPECT_EQ(run.training->model().count(), 0);
  EXPECT_TRUE(run.training->state().finished);
}

// Of one timestep nothing can be said of motion. Bug put back: looked at all the same; seen to
// fail.
TEST(ModelReduction, OneTimestepDecidesNothingOfMotion) {
  TinyCapture capture;
  capture.timesteps = 1;
  const Scene scene = tiny_capture(capture);
  TrainOptions options = thrifty_options();
  options.size = ModelSize::kGrown;
  Training training(scene, options);
  Validation validation(training.backend(), scene, options);
  ModelReduction reduction(training.backend(), options, made_bytes);
  training.run(31, reduction, validation);
  ASSERT_EQ(training.decisions().size(), 1u);
  EXPECT_EQ(training.decisions()[0].demoted + training.decisions()[0].promoted, 0);
  EXPECT_EQ(training.decisions()[0].psnr, 0) << "no image was drawn for it";
}

}  // namespace
}  // namespace tessera::testing
