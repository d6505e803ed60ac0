// Durations on the command line, and the time before its limit at which a training stops.
#include "tools/session/clock/time_limit.h"

#include <gtest/gtest.h>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

// Bug put back: a unit that is not known counts as seconds; seen to fail.
TEST(TimeLimit, ReadsDurations) {
  EXPECT_EQ(parse_duration("90"), 90);
  EXPECT_EQ(parse_duration("2.5"), 2.5);
  EXPECT_EQ(parse_duration("90s"), 90);
  EXPECT_EQ(parse_duration("90m"), 5400);
  EXPECT_EQ(parse_duration("2h"), 7200);
  EXPECT_EQ(parse_duration("1h30m"), 5400);
  for (const char* text : {"", "0", "-3", "2d", "h", "1h30", "1:30:00", "inf", "nan", "2 d"})
    EXPECT_THROW(parse_duration(text), InputError) << text;
}

class Planned : public ::testing::Test {
 protected:
  double now = 0;
  TimeLimit limit{1000, [this] { return now; }};
  /// The second at which a training without steps would leave.
  int leaves_at(int64_t gaussians) {
    for (now = 0; !limit.due(gaussians); now += 1)
      if (now > 2000) return -1;
    return int(now);
  }
};

// Bug put back: the time of saving left out of the room; seen to fail.
TEST_F(Planned, LeavesRoomForSaving) {
  EXPECT_EQ(leaves_at(1), 980) << "2 % of the limit";
  now = 0;
  limit.save(100, [&] { now += 10; });
  EXPECT_EQ(leaves_at(100), 960) << "twice what saving has taken";
  EXPECT_EQ(leaves_at(300), 920) << "three times as many Gaussians";
  limit.save(100, [&] { now += 1; });
  EXPECT_EQ(leaves_at(100), 960) << "the slowest save counts";
}

// Bug put back: longest_step_ left out of the room; seen to fail.
TEST_F(Planned, LeavesRoomForAStepAndForWorkInBetween) {
  now = 100;
  limit.begin_steps();
  now = 130;
  EXPECT_FALSE(limit.due_after_step(1));
  EXPECT_EQ(leaves_at(1), 950);
  now = 200;
  limit.whole([&] { now += 50; });
  EXPECT_EQ(leaves_at(1), 900);
  now = 979;
  EXPECT_FALSE(limit.over()) << "all is saved";
  now = 980;
  EXPECT_TRUE(limit.over());
}

// Bug put back: a limit of 0 counts; seen to fail.
TEST(TimeLimit, NoLimitIsNeverDue) {
  TimeLimit none(0, [] { return 1e9; });
  EXPECT_FALSE(none.due(1));
  EXPECT_FALSE(none.over());
}

}  // namespace
}  // namespace tessera
