// The masks of `synth patch`, the images of `render --dynamic-share` and the numbers of `evaluate
// --moving-masks` agree.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Bug put back: colours drawn in place of shares; seen to fail.
TEST(CliMoving, SharesMasksAndScoresFit) {
  const CliWorkspace work;
  const ChildResult made = work.run({"synth",
                                     "patch",
                                     "-o",
                                     work.at("patch"),
                                     "--layout",
                                     "dnerf",
                                     "--frames",
                                     "6",
                                     "--held-out-frames",
                                     "2",
                                     "--width",
                                     "40",
                                     "--height",
                                     "30",
                                     "--supersampling",
                                     "2",
                                     "--moving-share",
                                     "0.2",
                                     "--points",
                                     "50"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ChildResult trained = work.run(
      {"train", work.at("patch"), "-o", work.at("run"), "--iterations", "20", "--init-points",
       "600", "--batch", "2", "--static-fraction", "0.5", "--decide-motion", "false"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const std::string masks = work.at("patch/ground_truth/moving");
  const json scores =
      work.run_json({"evaluate", work.at("run"), "--split", "test", "--moving-masks", masks});
  work.run_json({"render", work.at("run"), "--cameras", work.at("patch"), "--split", "test",
                 "--dynamic-share", "-o", work.at("shares")});
  double weight = 0, inside = 0, moving = 0, covered = 0;
  for (const char* name : {"test/r_000.png", "test/r_001.png"}) {
    const Image8 share = read_png(work / "shares" / name), mask = read_png(masks + "/" + name);
    ASSERT_EQ(share.data.size(), 3 * mask.data.size());
    for (size_t p = 0; p < mask.data.size(); ++p) {
      EXPECT_EQ(share.data[3 * p], share.data[3 * p + 2]) << "grey";
      const double value = share.data[3 * p] / 255.0;
      weight += value;
      inside += mask.data[p] >= 128 ? value : 0;
      moving += mask.data[p] >= 192;
      covered += mask.data[p] >= 192 && share.data[3 * p] >= 128;
    }
  }
  ASSERT_GT(weight, 10);
  EXPECT_NEAR(scores["dynamic_weight_inside"], inside / weight, 0.01);  // shares are 8 bit
  EXPECT_NEAR(scores["moving_pixels_covered"], covered / moving, 0.02);
  EXPECT_FALSE(work.run_json({"evaluate", work.at("run")}).contains("moving_pixels_covered"));
}

// Bug put back: sizes ignored; seen to fail.
TEST(CliMoving, MasksThatDoNotFitAreNamed) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  work.expect_refused({"evaluate", work.at("run"), "--moving-masks", work.at("none")},
                      {"none", "no such folder"});
  std::filesystem::create_directories(work / "masks/test");
  write_png(work / "masks/test/r_000.png", {8, 8, 1, std::vector<uint8_t>(64)});
  work.expect_refused({"evaluate", work.at("run"), "--moving-masks", work.at("masks")},
                      {"masks/test/r_000.png"});
  write_png(work / "masks/test/r_000.png", {32, 32, 3, std::vector<uint8_t>(3072)});
  work.expect_refused({"evaluate", work.at("run"), "--moving-masks", work.at("masks")},
                      {"masks/test/r_000.png", "grey"});
}

}  // namespace
}  // namespace tessera::testing
