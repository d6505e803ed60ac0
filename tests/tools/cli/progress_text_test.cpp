// What: counts, share and time left of a stage, of known and of unknown length.
// Not: the bar on a terminal.
#include "tools/cli/progress_text.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(ProgressText, KnownTotals) {
  EXPECT_EQ(progress_text({0, 12, 0, 5}), "0/12 (0 %)");
  EXPECT_EQ(progress_text({3, 12, 0, 30}), "3/12 (25 %) 1:30 left");
  EXPECT_EQ(progress_text({9, 12, 6, 30}), "9/12 (75 %) 0:30 left");  // resumed at 6
  EXPECT_EQ(progress_text({12, 12, 0, 30}), "12/12 (100 %) 0:00 left");
  EXPECT_EQ(progress_share({3, 12, 0, 30}), 0.25);
}

// Bug put back: a share and a time left of totals that are not known, "0/0 (0 %)" and
// "2/0 (0 %) 0:-22 left"; seen to fail.
TEST(ProgressText, UnknownOrExceededTotals) {
  EXPECT_EQ(progress_text({0, 0, 0, 132}), "");
  EXPECT_EQ(progress_text({2, 0, 0, 132}), "2 done");
  EXPECT_EQ(progress_text({5, 4, 0, 132}), "5 done");
  EXPECT_EQ(progress_share({2, 0, 0, 132}), 0);
  EXPECT_EQ(progress_share({5, 4, 0, 132}), 0);
}

}  // namespace
}  // namespace tessera
