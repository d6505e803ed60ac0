// Windows of a clip: every timestep in one core, cores of equal length, timesteps beyond.
#include "ingest/clocks/windows.h"

#include <gtest/gtest.h>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

// Finds: cores that begin at I (T / N), which leaves timesteps at the end; the last timestep of
// a core in the next one, too.
TEST(Windows, HaveEveryTimestepOnceInCoresOfEqualLength) {
  for (const int64_t timesteps : {2, 7, 150, 1801})
    for (const int64_t count : {1, 2, 3, 7, 75}) {
      if (2 * count > timesteps) continue;
      int64_t next = 0;
      for (int64_t i = 0; i < count; ++i) {
        const TimestepRange core = range_of({i, count, 0}, timesteps);
        EXPECT_EQ(core.first, next);
        const int64_t length = core.last - core.first + 1;
        EXPECT_GE(length, timesteps / count);
        EXPECT_LE(length, timesteps / count + 1);
        next = core.last + 1;
      }
      EXPECT_EQ(next, timesteps);
    }
}

// Bug put back: timesteps beyond the clip; seen to fail.
TEST(Windows, ReachBeyondTheirCoresWithinTheClip) {
  const auto range = [](int64_t index) { return range_of({index, 3, 8}, 90); };
  EXPECT_EQ(range(0).first, 0);
  EXPECT_EQ(range(0).last, 37);
  EXPECT_EQ(range(1).first, 22);
  EXPECT_EQ(range(1).last, 67);
  EXPECT_EQ(range(2).first, 52);
  EXPECT_EQ(range(2).last, 89);
  EXPECT_THROW(range_of({0, 46, 8}, 90), InputError);
}

// Finds: counting from 0; text behind the numbers is passed over.
TEST(Windows, AreNamedFromOneOn) {
  EXPECT_EQ(window_of_text("2/12", "--window"), (Window{1, 12}));
  EXPECT_EQ(text_of(Window{1, 12}), "2/12");
  for (const char* wrong : {"0/4", "5/4", "1/0", "1", "a/b", "1/4x", "", "-1/4", "1/4/2"})
    EXPECT_THROW(window_of_text(wrong, "--window"), InputError) << wrong;
}

}  // namespace
}  // namespace tessera
