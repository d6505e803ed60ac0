// Results of runs as points, CSV and tables, and the records of a run that are accepted.
#include "tools/bench/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tools/bench/run.h"
#include "tools/bench/table_text.h"

namespace tessera {
namespace {

using nlohmann::json;

json run(const char* label, int64_t iterations, int64_t seed, double psnr, double seconds) {
  return {{"scene", "lego"},
          {"split", "val"},
          {"label", label},
          {"iterations", iterations},
          {"seed", seed},
          {"status", "done"},
          {"device", "cpu, 2 threads"},
          {"metrics", {{"psnr", psnr}, {"seconds", seconds}, {"bytes", 3 << 20}}}};
}

/// Three seeds of one point, one of them failed; two more points.
json some_cells() {
  json runs = {run("fast", 100, 1, 20, 2), run("fast", 100, 2, 22, 4), run("fast", 100, 3, 99, 9),
               run("fast", 900, 1, 25, 20), run("best", 900, 1, 25.5, 200)};
  runs[2]["status"] = "failed";
  runs[2]["error"] = "step 7: loss is not finite, \"mean\"";
  runs[2].erase("metrics");
  return runs;
}

// Bug put back: failed runs counted in n; seen to fail.
TEST(BenchReport, PointsAreMediansOverSeeds) {
  const json scenes = bench_points(some_cells());
  ASSERT_EQ(scenes.size(), 1u);
  ASSERT_EQ(scenes[0]["points"].size(), 3u);
  const json& point = scenes[0]["points"][0];
  EXPECT_EQ(point["n"], 2);
  EXPECT_EQ(point["metrics"]["psnr"]["median"], 21);
  EXPECT_EQ(point["metrics"]["seconds"]["least"], 2);
  EXPECT_EQ(point["metrics"]["seconds"]["most"], 4);
  EXPECT_FALSE(point["metrics"].contains("ssim")) << "not measured";
  EXPECT_EQ(point["errors"], json::array({"step 7: loss is not finite, \"mean\""}));
}

// Bug put back: quotes of a field not doubled; seen to fail.
TEST(BenchReport, CsvHasALineAPoint) {
  json runs = some_cells();
  runs[3]["device"] = "a \"big\", fast card";
  json scenes = bench_points(runs);
  mark_pareto_front(scenes);
  const std::string csv = csv_of(scenes);
  EXPECT_TRUE(csv.starts_with("scene,split,label,iterations,n,psnr,psnr_least,psnr_most,ssim"))
      << csv;
  EXPECT_NE(csv.find("\nlego,val,fast,100,2,21.0,20.0,22.0,,,,"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",true,true,\"a \"\"big\"\", fast card\"\n"), std::string::npos)
      << "frontier, knee, device of the second point: " << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  const long heading_end = long(csv.find('\n')), last_line = long(csv.rfind("\nlego"));
  EXPECT_EQ(std::count(csv.begin(), csv.begin() + heading_end, ',') + 1,
            std::count(csv.begin() + last_line, csv.end(), ','))
      << "as many fields as headings, and a comma in \"cpu, 2 threads\"";
}

// Bug put back: every step of a curve keeps the run's own iterations; seen to fail.
TEST(BenchReport, AStepOfACurveIsAPoint) {
  json whole = run("fast", 900, 1, 25, 20);
  whole["curve"] = {{{"iteration", 100}, {"seconds", 2}, {"psnr", 20}, {"ssim", 0.5}},
                    {{"iteration", 900}, {"seconds", 20}, {"psnr", 25}, {"ssim", 0.7}}};
  const json scenes = bench_points(curve_runs(json::array({whole})));
  ASSERT_EQ(scenes[0]["points"].size(), 2u);
  EXPECT_EQ(scenes[0]["points"][0]["iterations"], 100);
  EXPECT_EQ(scenes[0]["points"][0]["metrics"]["psnr"]["median"], 20);
  EXPECT_EQ(scenes[0]["points"][1]["metrics"]["ssim"]["median"], 0.7);
}

// Bug put back: the published figures of another scene are taken; seen to fail.
TEST(BenchReport, ATableHasThePublishedRowBeside) {
  json runs = {run("faster-gs", 900, 1, 25.125, 123.4), run("yang4d", 900, 1, 24, 50)};
  runs[0]["row"] = "faster-gs";
  runs[1]["row"] = "yang4d";
  json scenes = bench_points(runs);
  add_published(scenes, bench_table("dnerf"));
  const std::string text = tables_text(scenes, {"psnr", "ssim", "seconds", "bytes"});
  for (const char* part :
       {"**lego**, split val, on cpu, 2 threads",
        "| faster-gs | 900 | 1 | 25.12 | n/a | 123 | 3.00 |", "31.79 dB, SSIM 0.9600, 382 s",
        "25.33 dB [3]", "[3] published, measured elsewhere: Yang's 4DGS retrained by 4DGS-1K"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  EXPECT_EQ(text.find("33.35"), std::string::npos) << "of another scene:\n" << text;
}

// Bug put back: scenes are summed, not averaged; seen to fail.
TEST(BenchReport, SeveralScenesHaveAMean) {
  json runs = {run("fast", 9, 1, 20, 2), run("best", 9, 1, 30, 2), run("fast", 9, 1, 26, 2)};
  runs[2]["scene"] = "mic";
  const std::string text = tables_text(bench_points(runs), {"psnr"});
  EXPECT_NE(text.find("**mean of 2 scenes** (of their medians)"), std::string::npos) << text;
  EXPECT_NE(text.find("| fast | 9 | 23.00 |"), std::string::npos) << text;
  EXPECT_EQ(text.find("| best |"), text.rfind("| best |")) << "not of both scenes:\n" << text;
}

// Bug put back: a result of any fingerprint is believed; seen to fail.
TEST(BenchRun, OnlyACompleteResultOfTheSameCellIsUsed) {
  const testing::ScratchFolder folder;
  BenchRun wanted;
  wanted.scene.name = "lego";
  wanted.scene.split = "val";
  wanted.scene.fingerprint = "abc";
  wanted.label = "fast";
  const json described = describe_run(wanted);
  const auto status = [&] { return recorded_run(folder.path(), described)["status"]; };
  EXPECT_EQ(status(), "missing");
  const auto file = folder_of_run(folder.path(), wanted) / "result.json";
  make_folder(file.parent_path());
  json result = described;
  result["status"] = "done";
  result["metrics"] = {{"psnr", 20}};
  write_text_file(file, result.dump());
  EXPECT_EQ(status(), "done");
  EXPECT_EQ(recorded_run(folder.path(), described)["metrics"]["psnr"], 20);
  write_text_file(file, result.dump().substr(0, 50));
  EXPECT_EQ(status(), "missing") << "cut off";
  result["fingerprint"] = "of something else";
  write_text_file(file, result.dump());
  EXPECT_EQ(status(), "missing") << "another run's";
}

// Bug put back: the split left out of the fingerprint; seen to fail.
TEST(BenchRun, TheFingerprintCoversAllThatTheResultDependsOn) {
  const BenchRun run;
  const auto changed = [&](auto change) {
    BenchRun other;
    change(other);
    return run_fingerprint(other) != run_fingerprint(run);
  };
  EXPECT_TRUE(changed([](BenchRun& c) { c.options.lr_sh *= 2; }));
  EXPECT_TRUE(changed([](BenchRun& c) { c.scene.fingerprint = "x"; }));
  EXPECT_TRUE(changed([](BenchRun& c) { c.scene.split = "val"; }));
  EXPECT_TRUE(changed([](BenchRun& c) { c.score_at = {10}; }));
  EXPECT_TRUE(changed([](BenchRun& c) { c.scales = {2}; }));
  EXPECT_FALSE(changed([](BenchRun& c) { c.row = "full"; })) << "tables share cells";
}

}  // namespace
}  // namespace tessera
