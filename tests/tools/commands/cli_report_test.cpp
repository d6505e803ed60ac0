// `tessera report` on trained runs: charts, held-out views beside the truth, rendered once; files
// beside the page; the report of one run. The text of pages is tested in batch_report_test.cpp and
// report_page_test.cpp.
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
// shown, not of one a preset; views of the training split; no chart is written;
// seen to fail.
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
  EXPECT_EQ(count(page, "<svg"), 1u) << "the chart of the scene";
  EXPECT_NE(work.read("out/report/chart_capture.svg").find(">capture (test): "), std::string::npos);

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

// Bugs put back: the folder of the report in the current folder in place of the run's; a page whose
// addresses begin in the current folder; a run without metrics.json has no scores; seen to fail.
TEST(CliReport, OfOneRunIsAPageWithChartsAndViews) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run", {"--evaluate-every", "2"}).exit_code, 0);
  const json report = work.run_json({"report", work.at("run")});
  EXPECT_EQ(report["page"], work.at("run/report/index.html"));
  EXPECT_EQ(report["views"].size(), 1u);
  EXPECT_GT(report["views"][0]["psnr"], 5);
  EXPECT_EQ(report["preset"], json::parse(work.read("run/config.json"))["preset"]);
  EXPECT_NE(report["command"].get<std::string>().find(" train "), std::string::npos);
  EXPECT_GT(report["sizes"]["Model"], 0);
  EXPECT_FALSE(report["curves"]["psnr_test"].empty());
  for (const char* chart : {"psnr", "loss", "gaussians", "memory"})
    EXPECT_TRUE(fs::exists(work / ("run/report/" + std::string(chart) + ".svg"))) << chart;
  const std::string page = work.read("run/report/index.html");
  EXPECT_EQ(count(page, "<img "), 6u) << "truth, result and error, large and in a strip";
  EXPECT_EQ(count(page, "src=\"data:image/"), 6u);
  EXPECT_NE(page.find("href=\"../model.ply\""), std::string::npos);
  EXPECT_LT(page.size(), 5'000'000u);

  fs::rename(work / "capture", work / "moved");
  EXPECT_EQ(work.run({"report", work.at("run"), "-o", work.at("elsewhere")}).exit_code, 0);
  const std::string without = work.read("elsewhere/index.html");
  EXPECT_NE(without.find("The scene of this run is gone"), std::string::npos);
  EXPECT_NE(without.find("href=\"../run/model.ply\""), std::string::npos);
}

TEST(CliReport, OptionsOfTheOtherKindAreRefused) {
  const CliWorkspace work;
  work.write("batch/batch.yaml", "");
  work.expect_refused({"report", work.at("batch"), "-o", work.at("x")}, {"-o", "report of a run"});
}

TEST(CliReport, AFolderOfNoBatchIsRefused) {
  const CliWorkspace work;
  work.expect_refused({"report", work.at("capture")}, {"is no folder of a batch", "batch -o"});
  work.expect_refused({"report", work.at("nowhere")}, {"is no folder of a batch"});
}

}  // namespace
}  // namespace tessera::testing
