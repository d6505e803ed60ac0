// What: --ablation at the command line: over the preset, under what is typed; and a run with lazy
//       updates, whose checkpoints are behind what is handed out.
// Not: the rows (tests/recon4d/options/train_ablations_test.cpp).
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Seen to fail with the ablation applied after what is typed.
TEST(CliAblation, GoesOverThePresetAndUnderWhatIsTyped) {
  const CliWorkspace work;
  const ChildResult trained = work.train("run", {"--iterations", "2", "--preset", "fast",
                                                 "--ablation", "basis", "--tile-culling", "true"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const json config = json::parse(work.read("run/config.json"));
  EXPECT_EQ(config["ablation"], "basis");
  EXPECT_EQ(config["preset"], "fast");
  EXPECT_EQ(config["options"]["rectangular_bounds"], false);
  EXPECT_EQ(config["options"]["fused_optimizer"], false);
  EXPECT_EQ(config["options"]["tile_culling"], true);
  EXPECT_EQ(config["options"]["peak_gaussians"], 40000);
}

TEST(CliAblation, WrongNamesAndPairsAreRefused) {
  const CliWorkspace work;
  work.expect_refused(work.train_arguments("run", {"--ablation", "no-zorder"}),
                      {"unknown ablation 'no-zorder'", "did you mean 'no-z-order'", "full, basis"});
  work.expect_refused(
      work.train_arguments("run", {"--ablation", "basis", "--idle-updates", "lazy"}),
      {"idle_updates lazy needs the fused optimizer"});
  work.expect_refused(work.train_arguments("run", {"--idle-updates", "sometimes"}),
                      {"'idle_updates' is 'sometimes'", "dense, lazy, skip"});
  ASSERT_EQ(work.train("run", {"--stop-after", "2"}).exit_code, 0);
  work.expect_refused(
      {"train", work.at("capture"), "-o", work.at("run"), "--resume", "--ablation", "full"},
      {"--resume goes on with the options of the checkpoint"});
}

// Seen to fail with the checkpoint's own colours evaluated.
TEST(CliAblation, LazyRunsStopResumeAndEvaluate) {
  const CliWorkspace work;
  const std::vector<std::string> lazy = {"--ablation",        "full", "--batch", "1",
                                         "--init-time-scale", "0.05"};
  std::vector<std::string> half = lazy, dense = lazy;
  half.insert(half.end(), {"--stop-after", "9"});
  dense.insert(dense.end(), {"--stop-after", "9", "--idle-updates", "dense"});
  ASSERT_EQ(work.train("whole", lazy).exit_code, 0);
  ASSERT_EQ(work.train("halves", half).exit_code, 0);
  ASSERT_EQ(work.train("dense", dense).exit_code, 0);

  const auto psnr = [&](const char* model) {  // on the frames of which some are idle in each step
    return work
        .run_json({"evaluate", work.at(model), "--scene", work.at("capture"), "--split",
                   "train"})["psnr_float"]
        .get<double>();
  };
  EXPECT_EQ(psnr("halves/checkpoint.ckpt"), psnr("halves"));
  EXPECT_NEAR(psnr("halves"), psnr("dense"), 1e-5);

  const ChildResult resumed =
      work.run({"train", work.at("capture"), "-o", work.at("halves"), "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_TRUE(work.read("whole/model.ply") == work.read("halves/model.ply"));
}

}  // namespace
}  // namespace tessera::testing
