// The steps at which a checkpoint is due: by steps, by the clock, after slow checkpoints.
#include "tools/session/clock/session_events.h"

#include <gtest/gtest.h>

namespace tessera::testing {
namespace {

struct Clock {
  double now = 0;
  Stopwatch stopwatch() {
    return [this] { return now; };
  }
};

// Bug put back: a step that was just saved is due again; seen to fail.
TEST(CheckpointPlan, BySteps) {
  Clock clock;
  CheckpointPlan plan(100, clock.stopwatch());
  plan.begin(200);
  EXPECT_FALSE(plan.due(200)) << "resumed from there";
  EXPECT_EQ(plan.next_after(200), 300);
  clock.now = 1e6;
  EXPECT_FALSE(plan.due(299));
  EXPECT_TRUE(plan.due(300));
  plan.save(300, [] {});
  EXPECT_FALSE(plan.due(300));
  EXPECT_EQ(plan.next_after(350), 400);
}

TEST(CheckpointPlan, NoneBeforeTheEnd) {
  Clock clock;
  CheckpointPlan plan(0, clock.stopwatch());
  plan.begin(0);
  clock.now = 1e6;
  for (const int64_t step : {1, 1000, 30000}) EXPECT_FALSE(plan.due(step));
  EXPECT_GT(plan.next_after(0), int64_t{1} << 60);
}

// Bugs put back, each seen to fail: the time of writing not counted; the minute counted from the
// beginning of the last one.
TEST(CheckpointPlan, ByTheClockAtMostATwentieth) {
  Clock clock;
  CheckpointPlan plan({}, clock.stopwatch());
  clock.now = 500;  // loading
  plan.begin(0);
  EXPECT_FALSE(plan.due(1));
  clock.now = 559;
  EXPECT_FALSE(plan.due(7));
  clock.now = 560;
  EXPECT_TRUE(plan.due(8));
  plan.save(8, [&] { clock.now += 30; });
  EXPECT_FALSE(plan.due(9));
  clock.now = 590 + 599;
  EXPECT_FALSE(plan.due(10));
  clock.now = 590 + 600;
  EXPECT_TRUE(plan.due(11));
  EXPECT_GT(plan.next_after(11), int64_t{1} << 60);
  plan.save(11, [&] { clock.now += 1; });
  clock.now += 59;
  EXPECT_FALSE(plan.due(12));
  clock.now += 1;
  EXPECT_TRUE(plan.due(12));
}

}  // namespace
}  // namespace tessera::testing
