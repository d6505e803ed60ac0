// `tessera report` on trained runs: held-out views beside the truth, rendered once; files beside
// the page; the report of one run, of several, of a batch. The pages are tested in tests/browser/.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"
#include "tools/web/web_page.h"

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

// Finds: views of every seed, not of one a preset; views that were rendered are rendered again;
// a report that is older than the model is taken; addresses from the run's own report; images in
// the page of a batch without end.
TEST(CliReport, ShowsTheRunsOfABatchAndKeepsTheirViews) {
  const CliWorkspace work;
  for (const char* seed : {"1", "2"}) {
    const std::string run = std::string("out/runs/capture/fast/seed-") + seed;
    work.write("train.json", work.run_json(work.train_arguments(run, {"--seed", seed})).dump());
    fs::rename(work / "train.json", work / (run + "/train.json"));
    const json metrics = work.run_json({"evaluate", work.at(run)});
    work.write(run + "/metrics.json", metrics.dump());
  }
  const json report = work.run_json({"report", work.at("out")});
  EXPECT_EQ(report["kind"], "batch");
  EXPECT_EQ(report["batch"]["counts"]["done"], 2);
  const json point = report["batch"]["scenes"][0]["points"][0];
  EXPECT_GT(point["metrics"]["psnr"]["median"], 5);
  EXPECT_GT(point["metrics"]["seconds"]["median"], 0);
  EXPECT_EQ(json::parse(work.read("out/report/report.json")), report);
  EXPECT_EQ(work.read("out/report/report.csv").find("scene,split,label"), 0u);
  EXPECT_FALSE(report["runs"][0]["curves"]["loss"]["step"].empty());
  EXPECT_EQ(report["runs"][1]["views"].size(), 0u) << "one seed of a preset has images";
  ASSERT_EQ(report["runs"][0]["views"].size(), 1u);
  const std::string image = report["runs"][0]["views"][0]["truth"];
  EXPECT_TRUE(fs::exists(work / ("out/report/" + image))) << image;
  const std::string report_file = "out/runs/capture/fast/seed-1/report/report.json";
  if (carries_pages()) {
    EXPECT_EQ(report["runs"][0]["files"][0]["path"],
              "../runs/capture/fast/seed-1/report/index.html");
    EXPECT_EQ(count(work.read("out/report/index.html"), "data:image/jpeg;base64,"), 3u);
  }

  const auto drawn = fs::last_write_time(work / report_file);
  EXPECT_EQ(work.run({"report", work.at("out")}).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(work / report_file), drawn);
  EXPECT_EQ(work.train("out/runs/capture/fast/seed-1", {"--overwrite", "--seed", "9"}).exit_code,
            0);
  work.write("out/runs/capture/fast/seed-1/metrics.json", "{\"psnr\": 10}");
  EXPECT_EQ(work.run({"report", work.at("out")}).exit_code, 0);
  EXPECT_GT(fs::last_write_time(work / report_file), drawn) << "another model";
  const json without = work.run_json({"report", work.at("out"), "--no-images"});
  EXPECT_EQ(without["runs"][0]["views"].size(), 0u);
}

// Bugs put back: the folder of the report in the current folder in place of the run's; addresses
// that begin in the current folder; a run without metrics.json has no scores; images of earlier
// reports stay; those of somebody go; seen to fail.
TEST(CliReport, OfOneRunIsDataImagesAndAPage) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run", {"--evaluate-every", "2"}).exit_code, 0);
  const json report = work.run_json({"report", work.at("run")});
  EXPECT_EQ(report["page"],
            work.at(carries_pages() ? "run/report/index.html" : "run/report/report.json"));
  ASSERT_EQ(report["runs"].size(), 1u);
  const json& run = report["runs"][0];
  const json config = json::parse(work.read("run/config.json"));
  EXPECT_EQ(run["preset"], config["preset"]);
  EXPECT_EQ(run["options"], config["options"]);
  EXPECT_EQ(run["state"], "done");
  EXPECT_GT(run["scores"]["psnr"], 5);
  EXPECT_NE(run["command"].get<std::string>().find(" train "), std::string::npos);
  EXPECT_GT(run["size"]["model_bytes"], 0);
  EXPECT_GT(run["seconds"]["training"], 0);
  EXPECT_GT(run["seconds"]["command"], run["seconds"]["training"]);
  EXPECT_FALSE(run["curves"]["psnr_test"]["step"].empty());
  EXPECT_EQ(run["files"][0]["path"], "../model.ply");
  ASSERT_EQ(run["views"].size(), 1u);
  const json& view = run["views"][0];
  EXPECT_GT(view["psnr"], 5);
  EXPECT_EQ(view["role"], "worst");
  EXPECT_EQ(view["strip"], true);
  for (const char* image : {"truth", "result", "error"})
    EXPECT_GT(fs::file_size(work / ("run/report/" + view[image].get<std::string>())), 100u);
  json filed = json::parse(work.read("run/report/report.json"));
  filed["page"] = report["page"];
  EXPECT_EQ(filed, report);
  if (carries_pages()) {
    const std::string page = work.read("run/report/index.html");
    EXPECT_EQ(count(page, "data:image/jpeg;base64,"), 3u);
    EXPECT_LT(page.size(), 5'000'000u);
  }

  work.write("run/report/images/mine.jpg", "of somebody");
  fs::rename(work / "capture", work / "moved");
  EXPECT_EQ(work.run({"report", work.at("run"), "-o", work.at("elsewhere")}).exit_code, 0);
  const json without = json::parse(work.read("elsewhere/report.json"))["runs"][0];
  EXPECT_NE(without["image_note"].get<std::string>().find("The scene of this run is gone"),
            std::string::npos);
  EXPECT_TRUE(without["views"].empty()) << "never scored";
  EXPECT_EQ(without["files"][0]["path"], "../run/model.ply");
  EXPECT_EQ(work.run({"report", work.at("run")}).exit_code, 0);
  for (const char* image : {"truth", "result", "error"})
    EXPECT_FALSE(fs::exists(work / ("run/report/" + view[image].get<std::string>())))
        << "of the earlier report";
  EXPECT_EQ(work.read("run/report/images/mine.jpg"), "of somebody");
}

// Bug put back: the text of a warning ends the element of the data; seen to fail.
TEST(CliReport, TextOfARunDoesNotEndItsPage) {
  if (!carries_pages()) GTEST_SKIP() << "built without the pages";
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  work.write("run/log.jsonl", work.read("run/log.jsonl") +
                                  R"({"event": "warning", "text": "</script><b>odd \u00fc"})"
                                  "\n");
  EXPECT_EQ(work.run({"report", work.at("run")}).exit_code, 0);
  const std::string page = work.read("run/report/index.html");
  EXPECT_EQ(count(page, "</script><b>odd"), 0u);
  EXPECT_EQ(count(page, R"(\u003c/script>\u003cb>odd)"), 1u);
}

// Bugs put back: one folder without -o takes the report of both; runs of one name are not told
// apart; seen to fail.
TEST(CliReport, OfSeveralRunsComparesThem) {
  const CliWorkspace work;
  for (const char* run : {"a/seed", "b/seed"}) ASSERT_EQ(work.train(run).exit_code, 0);
  const std::vector<std::string> both{"report", work.at("a/seed"), work.at("b/seed")};
  work.expect_refused(both, {"-o is missing"});
  EXPECT_FALSE(fs::exists(work / "a/seed/report"));
  std::vector<std::string> named = both;
  named.insert(named.end(), {"-o", work.at("both")});
  const json report = work.run_json(named);
  EXPECT_EQ(report["kind"], "comparison");
  ASSERT_EQ(report["runs"].size(), 2u);
  EXPECT_EQ(report["runs"][0]["title"], "a/seed");
  EXPECT_EQ(report["runs"][1]["title"], "b/seed");
  EXPECT_EQ(report["runs"][1]["files"][0]["path"], "../b/seed/model.ply");
  work.expect_refused({"report", work.at("a/seed"), work.at("none"), "-o", work.at("both")},
                      {"none: is no run"});
}

TEST(CliReport, OptionsOfTheOtherKindAreRefused) {
  const CliWorkspace work;
  work.write("batch/batch.yaml", "");
  work.expect_refused({"report", work.at("batch"), "-o", work.at("x")}, {"-o", "report of a run"});
}

TEST(CliReport, AFolderOfNoBatchIsRefused) {
  const CliWorkspace work;
  work.expect_refused({"report", work.at("capture")}, {"is no folder of a batch", "batch -o"});
  work.expect_refused({"report", work.at("nowhere")}, {"nowhere: no such folder"});
}

}  // namespace
}  // namespace tessera::testing
