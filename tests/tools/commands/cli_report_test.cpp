// What: `tessera report` on runs that were trained: charts, held-out views beside the truth, drawn
//       once; files beside the page.
// Not: what the page says (batch_report_test.cpp).
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

size_t count(const std::string& text, const std::string& part) {
  size_t found = 0;
  for (size_t position = text.find(part); position != std::string::npos;
       position = text.find(part, position + 1))
    ++found;
  return found;
}

// Bugs put back: the key of the kept views without the model's bytes; the views of every seed
// shown, not of one a preset; views of the training split; seen to fail.
TEST(CliReport, ShowsRunsAndKeepsTheirViews) {
  const CliWorkspace work;
  for (const char* seed : {"1", "2"}) {
    const std::string run = std::string("out/runs/capture/fast/seed-") + seed;
    work.write("train.json", work.run_json(work.train_arguments(run, {"--seed", seed})).dump());
    fs::rename(work / "train.json", work / (run + "/train.json"));
    const json metrics = work.run_json({"evaluate", work.at(run)});
    work.write(run + "/metrics.json", metrics.dump());
  }
  const json report = work.run_json({"report", work.at("out")});
  EXPECT_EQ(report["counts"]["done"], 2);
  EXPECT_GT(report["scenes"][0]["points"][0]["metrics"]["psnr"]["median"], 5);
  EXPECT_GT(report["scenes"][0]["points"][0]["metrics"]["seconds"]["median"], 0);
  EXPECT_EQ(json::parse(work.read("out/report/report.json")), report);
  EXPECT_EQ(work.read("out/report/report.csv").find("scene,split,label"), 0u);
  const std::string page = work.read("out/report/index.html");
  EXPECT_EQ(count(page, "data:image/png;base64,"), 2u) << "one held-out view and its truth";
  EXPECT_EQ(count(page, "truth: test/"), 2u) << "alt and caption";
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_TRUE(count(page, "data:image/svg+xml") == 1 || count(page, "no gnuplot found") == 1);

  const fs::path kept = work / "out/runs/capture/fast/seed-1/held_out/0_drawn.png";
  const auto drawn = fs::last_write_time(kept);
  EXPECT_EQ(work.run({"report", work.at("out")}).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(kept), drawn);
  EXPECT_EQ(work.read("out/report/index.html"), page);
  EXPECT_EQ(work.train("out/runs/capture/fast/seed-1", {"--overwrite", "--seed", "9"}).exit_code,
            0);
  work.write("out/runs/capture/fast/seed-1/metrics.json", "{\"psnr\": 10}");
  EXPECT_EQ(work.run({"report", work.at("out")}).exit_code, 0);
  EXPECT_GT(fs::last_write_time(kept), drawn) << "another model";
}

TEST(CliReport, AFolderOfNoBatchIsRefused) {
  const CliWorkspace work;
  work.expect_refused({"report", work.at("capture")}, {"is no folder of a batch", "batch -o"});
  work.expect_refused({"report", work.at("nowhere")}, {"is no folder of a batch"});
}

}  // namespace
}  // namespace tessera::testing
