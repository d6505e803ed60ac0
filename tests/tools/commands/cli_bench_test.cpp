// `tessera bench`: the keys of its JSON, the load it makes, and invalid options. Times are not
// tested.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

/// `tessera bench capture` with few steps of a small load, overridden by `more`.
std::vector<std::string> bench(const CliWorkspace& work, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"bench", work.at("capture")};
  const std::pair<const char*, const char*> tiny[] = {
      {"--backend", "cpu"}, {"--steps", "2"},     {"--warm-up", "1"},
      {"--batch", "3"},     {"--carve", "false"}, {"--init-points", "50"}};
  for (const auto& [option, value] : tiny)
    if (std::find(more.begin(), more.end(), option) == more.end())
      arguments.insert(arguments.end(), {option, value});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// Bug put back: the stages of the warm-up are counted; seen to fail.
TEST(CliBench, ReportsWhatWasMeasured) {
  const CliWorkspace work;
  const json result = work.run_json(bench(work, {"--gaussians", "777"}));
  EXPECT_EQ(result["device"].get<std::string>().substr(0, 5), "cpu, ");
  EXPECT_EQ(result["gaussians"], 777);
  EXPECT_EQ(result["pixels"], 3 * 32 * 32) << "two frames, the first of them twice";
  EXPECT_GT(result["splats"], 0);
  EXPECT_GE(result["instances"], result["splats"]);
  EXPECT_GT(result["step_ms"], 0);
  EXPECT_GT(result["copy_gb_per_s"], 0);
  EXPECT_GT(result["peak_device_bytes"], 0);
  double sum = 0;
  for (const char* name :
       {"project", "bin", "blend", "photometric", "blend_backward", "project_backward"}) {
    ASSERT_TRUE(result["stages"].contains(name)) << name;
    const json& stage = result["stages"][name];
    EXPECT_GT(stage["ms"], 0) << name;
    for (const char* key : {"gbytes", "gb_per_s", "floor_ms"})  // devices count their bytes
      EXPECT_GE(stage[key], 0) << name << "." << key;
    sum += stage["ms"].get<double>();
  }
  EXPECT_LE(sum, result["step_ms"]);
}

// Bug put back: both sets rounded down; seen to fail.
TEST(CliBench, MakesTheRequestedNumberOfGaussians) {
  const CliWorkspace work;
  const auto count = [&](const char* gaussians, const char* static_fraction) {
    return work
        .run_json(bench(work, {"--gaussians", gaussians, "--static-fraction", static_fraction}))
        .at("gaussians");
  };
  EXPECT_EQ(count("101", "0.37"), 101);
  EXPECT_EQ(count("11", "1"), 11) << "fewer than the initial ones";
  EXPECT_EQ(count("0", "0.37"), 50) << "the initial ones";
}

TEST(CliBench, ATableForPeople) {
  const CliWorkspace work;
  const ChildResult result = work.run(bench(work, {}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"50 Gaussians", "GB/s", "blend_backward", "step, wall time"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part << " is not in " << result.out;
}

// Bug put back: an opacity of 1 is let through; seen to fail.
TEST(CliBench, RefusesWhatCannotBeMeasured) {
  const CliWorkspace work;
  work.expect_refused({"bench", work.at("nowhere")}, {"nowhere", "no such folder"});
  work.expect_refused(bench(work, {"--opacity", "1"}), {"--opacity must be"});
  work.expect_refused(bench(work, {"--gaussians", "-1"}), {"--gaussians is negative"});
  work.expect_refused(bench(work, {"--steps", "0"}), {"--steps of at least 1"});
}

}  // namespace
}  // namespace tessera::testing
