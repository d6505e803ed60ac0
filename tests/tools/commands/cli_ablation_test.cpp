// The option --ablation on the command line: it overrides the preset, and explicit options override
// it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Seen to fail with the ablation applied after what is typed.
TEST(CliAblation, OverridesThePresetAndIsOverriddenByOptions) {
  const CliWorkspace work;
  const ChildResult trained = work.train(
      "run",
      {"--iterations", "2", "--preset", "fast", "--ablation", "basis", "--opacity-bounds", "true"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const json config = json::parse(work.read("run/config.json"));
  EXPECT_EQ(config["ablation"], "basis");
  EXPECT_EQ(config["preset"], "fast");
  EXPECT_EQ(config["options"]["rectangular_bounds"], false);
  EXPECT_EQ(config["options"]["fused_optimizer"], false);
  EXPECT_EQ(config["options"]["opacity_bounds"], true);
  EXPECT_EQ(config["options"]["thin_rounds"], 3);
}

TEST(CliAblation, WrongNamesAndPairsAreRefused) {
  const CliWorkspace work;
  work.expect_refused(work.train_arguments("run", {"--ablation", "no-zorder"}),
                      {"unknown ablation 'no-zorder'", "did you mean 'no-z-order'", "full, basis"});
  work.expect_refused(
      work.train_arguments("run", {"--ablation", "basis", "--idle-updates", "skip"}),
      {"idle_updates skip needs the fused optimizer"});
  work.expect_refused(work.train_arguments("run", {"--idle-updates", "sometimes"}),
                      {"'idle_updates' is 'sometimes'", "dense, skip"});
  ASSERT_EQ(work.train("run", {"--stop-after", "2"}).exit_code, 0);
  work.expect_refused(
      {"train", work.at("capture"), "-o", work.at("run"), "--resume", "--ablation", "full"},
      {"--resume goes on with the options of the checkpoint"});
}

}  // namespace
}  // namespace tessera::testing
