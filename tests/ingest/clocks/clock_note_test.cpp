// The line about clocks: source, largest offset and its camera.
#include "ingest/clocks/clock_note.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Bugs put back, each seen to fail: the largest offset by sign; a source of some taken for all.
TEST(ClockNote, SaysSourceAndLargestOffset) {
  const std::vector<std::string> cameras{"cam00", "cam01", "cam02"};
  EXPECT_EQ(clock_note(cameras, {{0, 0, 0.001, "motion"},
                                 {0.02, 0.02, 0.001, "motion"},
                                 {-0.0417, -0.0417, 0.001, "motion"}}),
            "clocks: aligned by motion, by up to 0.0417 s (cam02)");
  EXPECT_EQ(clock_note(cameras, {{0.5, 0.5, 0, "audio"}, {0, 0, 0, "audio"}, {0, 0, 1, "none"}}),
            "clocks: aligned by sound (2 of 3 cameras), by up to 0.5000 s (cam00)");
  const ClipClock right{0, 0.0001, 0.001, "container"}, unknown{0, 0, 0, "none"};
  EXPECT_EQ(clock_note(cameras, {right, right, right}),
            "clocks: compared by the times in the files (timecode); none needed a change");
  EXPECT_EQ(clock_note(cameras, {unknown, unknown, unknown}),
            "clocks: the times of the files are taken as they are");
}

}  // namespace
}  // namespace tessera
