// Lines about many cameras are said once.
#include "ingest/steps/alike_warnings.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Bugs put back, each seen to fail: names compared within words; the other lines kept.
TEST(AlikeWarnings, AreSaidOnceWithTheNamesOfTheOthers) {
  const std::vector<std::string> cameras{"cam0", "cam01", "cam1", "cam2", "7"};
  const std::vector<std::string> lines{"a/cam0.mp4: camera cam0 is interlaced",
                                       "cam01: begins 0.7 s late",
                                       "a/cam01.mp4: camera cam01 is interlaced",
                                       "the sweep found 7 points",
                                       "cam2: begins 0.7 s late",
                                       "a/cam2.mp4: camera cam2 is interlaced",
                                       "cam1: is dark by 0.7",
                                       "no camera"};
  const std::vector<std::string> expected{
      "a/cam0.mp4: camera cam0 is interlaced (likewise: cam01, cam2)",
      "cam01: begins 0.7 s late",
      "the sweep found 7 points",
      "cam2: begins 0.7 s late",
      "cam1: is dark by 0.7",
      "no camera"};
  EXPECT_EQ(merged_alike(lines, cameras), expected);
}

}  // namespace
}  // namespace tessera
