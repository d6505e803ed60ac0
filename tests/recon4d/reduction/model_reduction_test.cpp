// Trainings with decisions: how many Gaussians are left after them, and that a resumed training
// decides as one that was never stopped. The choices are tested in decision_schedule_test.cpp,
// motion_choice_test.cpp and pruning_choice_test.cpp, what they rest on in contributions_test.cpp,
// pruning_test.cpp, static_demotion_test.cpp and dynamic_promotion_test.cpp.
// Source: failure modes C13, E5.
#include "recon4d/reduction/model_reduction.h"

#include <gtest/gtest.h>

#include <numeric>

#include "recon4d/model/checkpoint.h"
#include "recon4d/model/element_edits.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/separate_backend.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

/// A training with its decisions, from its beginning or from a state.
struct ReducedTraining {
  Scene scene;
  std::unique_ptr<Training> training;
  std::unique_ptr<Validation> validation;
  std::unique_ptr<ModelReduction> reduction;

  explicit ReducedTraining(const TrainOptions& options, std::optional<Checkpoint> from = {},
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
  ReducedTraining& run(int64_t iteration) {
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

// Bug put back: the goal computed again in every round; seen to fail.
TEST(ModelReduction, TheLastRoundLeavesTheKneeOfTheFirst) {
  const ReducedTraining run = std::move(ReducedTraining(thrifty_options()).run(180));
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

// Bug put back: a trial at every decision; seen to fail.
TEST(ModelReduction, DynamicGaussiansAreTriedAtTheFirstAndTheLast) {
  TrainOptions options = thrifty_options();
  options.static_fraction = 0;
  options.split_by_motion = false;
  const ReducedTraining run = std::move(ReducedTraining(options).run(180));
  ASSERT_EQ(run.decisions().size(), 7u);
  for (const ReductionReport& report : run.decisions()) {
    const bool tries = report.iteration == 30 || report.iteration == 180;
    EXPECT_EQ(report.demoted > 0, tries) << report.iteration;
  }
}

// C13. Bug put back: the goal without its spare; seen to fail.
TEST(ModelReduction, TheLastRoundLeavesALittleMoreThanIsAskedFor) {
  TrainOptions options = thrifty_options();
  options.max_gaussians = 80;
  EXPECT_EQ(ReducedTraining(options).run(180).training->model().count(), 83) << "1.04 of it";
  options.max_gaussians = 0;
  options.max_bytes = 5000;
  options.decide_motion = false;
  const int64_t bytes = made_bytes(ReducedTraining(options).run(180).training->model());
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
    const ReducedTraining run = std::move(ReducedTraining(options).run(101));
    const ReductionReport& first = run.decisions().front();
    EXPECT_GT(first.removed, 0) << decibels;
    return first.goal;
  };
  const int64_t near = left(0.2), far = left(3);
  EXPECT_LT(far, near);
}

// Bug put back: `decided` ignored; seen to fail.
TEST(ModelReduction, DecidesOnceAtAStepAlsoAfterAResume) {
  ReducedTraining run = std::move(ReducedTraining(thrifty_options()).run(101));
  ASSERT_EQ(run.decisions().size(), 4u);
  EXPECT_EQ(run.training->state().decided, 101);
  EXPECT_FALSE(run.reduction->act(run.training->trainer(), {}).has_value());
  Checkpoint half = run.saved();
  EXPECT_EQ(half.state.decided, 101);
  EXPECT_EQ(half.state.goal, run.decisions().back().knee);
  ReducedTraining again(thrifty_options(), std::move(half));
  EXPECT_FALSE(again.reduction->act(again.training->trainer(), {}).has_value());
  EXPECT_EQ(again.training->model().count(), run.training->model().count());
  // stopped at the step but before the decision it is made up for
  ReducedTraining undecided(thrifty_options());
  undecided.run(100).training->run(101);
  ReducedTraining late(thrifty_options(), undecided.saved());
  ASSERT_TRUE(late.reduction->act(late.training->trainer(), {}).has_value());
  EXPECT_TRUE(state_bits(late.training->state()) == state_bits(run.training->state()));
}

// Bug put back: images of the host handed to the stages; seen to fail.
TEST(ModelReduction, IsTheSameInASeparateMemory) {
  const ReducedTraining here = std::move(ReducedTraining(thrifty_options()).run(200));
  testing::SeparateBackend backend;
  ReducedTraining separate(thrifty_options(), {}, &backend);
  separate.run(200);
  EXPECT_GT(here.training->model().static_set.count(), 0);
  EXPECT_TRUE(state_bits(separate.training->state().clone_to(host_memory())) ==
              state_bits(here.training->state()));
  EXPECT_EQ(backend.strays, 0);
}

// A device need not hold the buffers of a step and those of a scoring pass at once. Bug put back:
// memory trimmed with the buffers of the step in it; seen to fail.
TEST(ModelReduction, MeasuresWithoutTheBuffersOfAStep) {
  testing::SeparateBackend backend;
  SeparateMemory& memory = backend.separate_memory;
  ReducedTraining run(thrifty_options(), {}, &backend);
  run.training->run(30);
  memory.buffers_at_trim.clear();
  const int64_t before = memory.buffers();
  ASSERT_TRUE(run.reduction->act(run.training->trainer(), {}).has_value());
  ASSERT_FALSE(memory.buffers_at_trim.empty());
  EXPECT_LT(memory.buffers_at_trim[0], before);
}

// E5. Bug put back: the goal not read from the checkpoint; seen to fail.
TEST(ModelReduction, ResumeIsBitEqual) {
  for (const IdleUpdate updates : {IdleUpdate::kDense, IdleUpdate::kSkip}) {
    TrainOptions options = thrifty_options();
    options.idle_updates = updates;
    const ReducedTraining whole = std::move(ReducedTraining(options).run(200));
    EXPECT_TRUE(whole.training->state().has_blocks());
    for (const int64_t half : {100, 140, 190}) {
      const ReducedTraining first = std::move(ReducedTraining(options).run(half));
      const ReducedTraining second = std::move(ReducedTraining(options, first.saved()).run(200));
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
    const ReducedTraining run(options);
    EXPECT_EQ(run.training->trainer().sample_frames().kernels.deterministic, deterministic);
  }
}

// Density control may have removed them all. Bug put back: thinned like any other; seen to fail,
// by never coming back.
TEST(ModelReduction, NoGaussiansAreNothingToThin) {
  TrainOptions options = thrifty_options();
  options.max_gaussians = 50;
  ReducedTraining run(options);
  run.run(100);
  StateEdit all;
  for (int k = 0; k < 2; ++k) {
    all.dropped[k].resize(size_t(run.training->state().set(k).count()));
    std::iota(all.dropped[k].begin(), all.dropped[k].end(), 0);
  }
  run.training->trainer().apply(all);
  run.run(200);
  EXPECT_EQ(run.training->model().count(), 0);
  EXPECT_TRUE(run.training->state().finished);
}

// One timestep contains no information on motion. Bug put back: checked all the same; seen to
// fail.
TEST(ModelReduction, OneTimestepDecidesNothingOfMotion) {
  const Scene scene = tiny_capture({.timesteps = 1});
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
