// `tessera bench --sizes` on a tiny capture: budgets are shares of the reference's final size; its
// output, the reuse of finished runs, and a failed reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/child_process.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Words = std::vector<std::string>;

class CliSizes : public ::testing::Test {
 protected:
  Words sizes(const Words& more = {}) const {
    Words all{
        "bench",       work.at("capture"), "-o",    work.at("out"), "--sizes", "--presets",
        "yang4d,fast", "--shares",         "2,4",   "--iterations", "4",       "--init-points",
        "60",          "--carve",          "false", "--backend",    "cpu"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  json cell(const std::string& label, const std::string& file) const {
    return json::parse(std::ifstream(work / ("out/runs/capture/" + label + "/4/1/" + file)));
  }
  WrittenFiles results() const { return work.written("out/runs", "result.json"); }
  CliWorkspace work;
};

// Bugs put back, each seen to fail: max_gaussians not set; the last preset as the reference; the
// model's bytes as the shipped ones; no chart is written.
TEST_F(CliSizes, BudgetsAreSharesOfTheReference) {
  const ChildResult run = work.run(sizes());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto first = results();
  EXPECT_EQ(first.size(), 4u);
  const json reference = cell("yang4d", "result.json")["metrics"];
  const int64_t count = reference["num_gaussians"];
  int64_t largest = 1000000;  // a small file is mostly what two sets need whatever their counts
  for (const int64_t share : {2, 4}) {
    const std::string label = "fast+one-in-" + std::to_string(share) + "-of-yang4d";
    const int64_t asked = (count + share / 2) / share;
    EXPECT_EQ(cell(label, "config.json")["options"]["max_gaussians"], asked);
    const json metrics = cell(label, "result.json")["metrics"];
    EXPECT_LE(metrics["num_gaussians"], asked);
    EXPECT_EQ(metrics["num_static"].get<int64_t>() + metrics["num_dynamic"].get<int64_t>(),
              metrics["num_gaussians"]);
    EXPECT_LT(metrics["shipped_bytes"], largest) << share;
    largest = metrics["shipped_bytes"];
  }
  ASSERT_EQ(work.run({"export", work.at("out/runs/capture/yang4d/4/1"), "-o", work.at("shipped"),
                      "--format", "tessera", "--single"})
                .exit_code,
            0);
  EXPECT_EQ(reference["shipped_bytes"], fs::file_size(work / "shipped/scene.t4d"));
  for (const char* row :
       {"| yang4d | 4 | 1 |", "| fast | 4 | 1 |", "| fast, 1/2 of yang4d | 4 | 1 |",
        "| fast, 1/4 of yang4d | 4 | 1 |", "shipped MiB"})
    EXPECT_NE(run.out.find(row), std::string::npos) << row << " is not in\n" << run.out;
  EXPECT_EQ(work.read("out/sizes.md"), run.out);
  const std::string csv = work.read("out/sizes.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
  EXPECT_NE(csv.find("shipped_bytes"), std::string::npos);
  fs::remove(work / "out/sizes.md");
  const ChildResult plot = work.run({"bench", "--sizes", "--plot", "-o", work.at("out")});
  EXPECT_EQ(plot.out, run.out) << plot.err;
  EXPECT_EQ(work.run(sizes()).exit_code, 0);
  EXPECT_EQ(results(), first) << "what is done is not done again";
  EXPECT_NE(work.read("out/sizes.svg").find(">capture (test)<"), std::string::npos);
}

// Bug put back: the budgets' cells written to the report when they are done; seen to fail.
TEST_F(CliSizes, AKilledOneCanBeDrawn) {
  ChildProcess killed(sizes({"--seeds", "1,2"}), work.path());
  ASSERT_TRUE(killed.wait_until([&] { return results().size() > 4; }));
  killed.send(SIGKILL);
  killed.wait();
  EXPECT_EQ(json::parse(work.read("out/sizes.json"))["cells"].size(), 8u);
  const ChildResult plot = work.run({"bench", "--sizes", "--plot", "-o", work.at("out")});
  EXPECT_EQ(plot.exit_code, 0) << plot.err;
  EXPECT_NE(plot.out.find("| fast, 1/4 of yang4d | 4 | "), std::string::npos) << plot.out;
}

// Bug put back: budgets of a reference that is not there, with the preset's own limit; seen to
// fail.
TEST_F(CliSizes, BudgetsWaitForTheReference) {
  fs::create_directories(work / "out/runs/capture/yang4d/4");
  work.write("out/runs/capture/yang4d/4/1", "in the way");
  const ChildResult run = work.run(sizes());
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_EQ(results().size(), 1u) << "the other preset alone";
  EXPECT_NE(run.out.find("waits for row yang4d"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("2 of 4 runs are not done yet"), std::string::npos) << run.err;
  work.expect_refused(sizes({"--shares", "0"}), {"--shares", "0"});
  work.expect_refused(sizes({"--max-gaussians", "9"}), {"--max-gaussians", "--shares"});
  work.expect_refused(sizes({"--chart"}), {"choose one of"});
}

}  // namespace
}  // namespace tessera::testing
