// The steps of decisions, derived from the options, and the decisions due at each of them. Their
// use in a training is tested in model_reduction_test.cpp.
#include "recon4d/reduction/decision_schedule.h"

#include <gtest/gtest.h>

namespace tessera::testing {
namespace {

using Steps = std::vector<int64_t>;

/// Grows until 100, prunes at 101, 127, 153 and 180, decides on motion at 30, 60 and 90, too.
TrainOptions four_rounds() {
  TrainOptions options;
  options.iterations = options.schedule_iterations = 200;
  options.motion = Motion::kPair;
  options.size = ModelSize::kKnee;
  options.decide_motion = true;
  options.densify_until = 100;
  options.decide_interval = 30;
  options.thin_rounds = 4;
  options.thin_until = 180;
  return options;
}

Steps decision_steps(const TrainOptions& options) {
  const DecisionSchedule schedule(options);
  Steps steps;
  constexpr size_t kMost = 20;  // more than there are: a step that is its own next one has no end
  for (int64_t i = schedule.next_after(0); i < 1000000 && steps.size() < kMost;
       i = schedule.next_after(i))
    steps.push_back(i);
  return steps;
}

// Bug put back: thin_until not scaled with the schedule; seen to fail.
TEST(DecisionSchedule, DecidesAtItsSteps) {
  TrainOptions options = four_rounds();
  EXPECT_EQ(decision_steps(options), (Steps{30, 60, 90, 101, 127, 153, 180}));
  options.motion = Motion::kNone;
  EXPECT_EQ(decision_steps(options), (Steps{101, 127, 153, 180}));
  options.motion = Motion::kPair;
  options.decide_motion = false;
  options.thin_rounds = 1;
  EXPECT_EQ(decision_steps(options), (Steps{101}));
  options.size = ModelSize::kGrown;
  EXPECT_EQ(decision_steps(options), Steps{});
  EXPECT_TRUE(DecisionSchedule(options).has_pruned(0));
  for (const auto& [key, value] : {std::pair<const char*, OptionValue>{"max_bytes", 9},
                                   {"within_db", 0.5},
                                   {"max_gaussians", 100}}) {
    TrainOptions asked = options;
    asked.peak_gaussians = 260;
    set_option(asked, key, value);
    EXPECT_EQ(decision_steps(asked), (Steps{101})) << key;
  }
  options = four_rounds();
  options.iterations = 100;  // half of the schedule
  EXPECT_EQ(decision_steps(options), (Steps{15, 30, 45, 51, 64, 77, 90}));
  options = four_rounds();
  options.thin_until = 400;
  EXPECT_EQ(decision_steps(options), (Steps{30, 60, 90, 101})) << "those before the end";
}

// Bug put back: pruning taken to be over at its first round; seen to fail.
TEST(DecisionSchedule, PruningIsOverAfterTheLastRound) {
  const DecisionSchedule schedule(four_rounds());
  for (int64_t i : {0, 101, 179}) EXPECT_FALSE(schedule.has_pruned(i)) << i;
  for (int64_t i : {180, 200}) EXPECT_TRUE(schedule.has_pruned(i)) << i;
}

// Bug put back: promotion at the last round, too; seen to fail.
TEST(DecisionSchedule, WhatIsDueAtAStep) {
  const DecisionSchedule schedule(four_rounds());
  struct Expected {
    int64_t iteration, decided, rounds_left;
    bool motion, prune, promote;
  };
  for (const Expected& e : {Expected{29, 0, 0, false, false, false},
                            {30, 0, 0, true, false, false},  // the first decision
                            {60, 30, 0, true, false, true},
                            {60, 60, 0, false, false, false},  // done before
                            {101, 90, 4, true, true, true},
                            {153, 127, 2, true, true, true},
                            {180, 153, 1, true, true, false}}) {  // the last round
    const DueDecision due = schedule.due(e.iteration, e.decided);
    EXPECT_EQ(due.iteration, e.iteration);
    EXPECT_EQ(due.rounds_left, e.rounds_left) << e.iteration;
    EXPECT_EQ(due.motion, e.motion) << e.iteration;
    EXPECT_EQ(due.prune, e.prune) << e.iteration;
    EXPECT_EQ(due.promote, e.promote) << e.iteration;
    EXPECT_EQ(due.any(), e.motion || e.prune) << e.iteration;
  }
  TrainOptions options = four_rounds();
  options.motion = Motion::kNodes;
  EXPECT_FALSE(DecisionSchedule(options).due(101, 0).motion) << "nodes carry the Gaussians";
  EXPECT_TRUE(DecisionSchedule(options).due(101, 0).prune);
}

// Bugs put back, each seen to fail: at every decision; without rounds at the first alone.
TEST(DecisionSchedule, DemotionIsTriedAtTheFirstAndTheLast) {
  const auto tried = [](const TrainOptions& options) {
    const DecisionSchedule schedule(options);
    Steps steps;
    int64_t decided = 0;
    for (const int64_t i : decision_steps(options)) {
      if (schedule.due(i, decided).demote) steps.push_back(i);
      decided = i;
    }
    return steps;
  };
  TrainOptions options = four_rounds();
  EXPECT_EQ(tried(options), (Steps{30, 180}));
  options.size = ModelSize::kGrown;
  EXPECT_EQ(tried(options), (Steps{30, 90})) << "no rounds";
  options.decide_motion = false;
  EXPECT_EQ(tried(options), Steps{});
}

// Bug put back: at every decision; seen to fail.
TEST(DecisionSchedule, MissedOnesAreSpawnedAtTheFirst) {
  TrainOptions options = four_rounds();
  EXPECT_FALSE(DecisionSchedule(options).due(30, 0).spawn_missed);
  options.spawn_missed = true;
  EXPECT_FALSE(DecisionSchedule(options).due(29, 0).spawn_missed);
  EXPECT_TRUE(DecisionSchedule(options).due(30, 0).spawn_missed);
  EXPECT_FALSE(DecisionSchedule(options).due(60, 30).spawn_missed);
}

}  // namespace
}  // namespace tessera::testing
