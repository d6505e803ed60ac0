// The data of a run's report from records written here: curves, decisions in sentences, scores,
// warnings, and records that are damaged or missing.
#include "tools/report/run_report.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using nlohmann::json;

std::string lines(const std::vector<json>& events) {
  std::string log;
  for (const json& event : events) log += event.dump() + "\n";
  return log;
}

json steps(int64_t step, double loss, int64_t num_static) {
  return {{"event", "steps"},         {"iteration", step},  {"loss", loss},
          {"num_static", num_static}, {"num_dynamic", 500}, {"peak_device_bytes", 1000 * step}};
}

json start(int64_t step, const char* host) {
  return {{"event", "start"},
          {"iteration", step},
          {"time", "2026-11-24T09:30:00Z"},
          {"host", host},
          {"initialisation", host},
          {"command", {"/opt/tessera", "run", "my room"}}};
}

RunRecords usual_records() {
  RunRecords records;
  records.config = {{"tessera", "0.1.0"}, {"preset", "balanced"}, {"device", "CPU"}};
  records.stages = json::parse(R"({"train": {"seconds": 60.0}, "ingest": {"seconds": 3.5,
      "result": {"warnings": ["cam03 is dark"]},
      "inputs": {"cloud": "sparse", "contents of the capture": "89a7", "as it is": false}}})");
  records.log = lines(
      {start(0, "first"),
       {{"event", "warning"}, {"text", "few views"}},
       steps(50, 0.3, 900),
       {{"event", "validation"}, {"iteration", 60}, {"psnr", 21.5}},
       steps(100, 0.2, 950),
       {{"event", "evaluation"}, {"iteration", 100}, {"splits", {{"test", {{"psnr", 22.5}}}}}}});
  return records;
}

std::string text_of(const json& report) {
  std::string text;
  for (const json& decision : report["decisions"])
    text += decision["step"].dump() + ": " + decision["text"].get<std::string>() + "\n";
  return text;
}

TEST(RunReport, CamerasHaveWhatTheTrainingLearnt) {
  RunRecords records = usual_records();
  records.stages["ingest"]["result"]["camera_table"] = {{{"name", "a"}}, {{"name", "b"}}};
  records.log +=
      lines({{{"event", "end"}, {"clocks", {{"a", 0.002}, {"b", -0.002}}}, {"readouts", nullptr}}});
  EXPECT_EQ(run_report(records)["cameras"],
            json::parse(R"([{"name": "a", "clock_learnt_s": 0.002, "readout_learnt_s": null},
                            {"name": "b", "clock_learnt_s": -0.002, "readout_learnt_s": null}])"));
}

// Bug put back: a quote in a word ends the quotes around it; seen to fail.
TEST(RunReport, TheCommandCanBeTypedAgain) {
  RunRecords records;
  json event = start(0, "a");
  event["command"] = {"tessera", "run", "it's", ""};
  records.log = lines({event});
  EXPECT_EQ(run_report(records)["command"], "tessera run 'it'\\''s' ''");
}

// Bug put back: hashes are among the options of ingest; seen to fail.
TEST(RunReport, HasMachineStagesAndCurves) {
  const json report = run_report(usual_records());
  EXPECT_EQ(report["ingest_options"], json({{"cloud", "sparse"}}));
  EXPECT_EQ(report["command"], "tessera run 'my room'");
  EXPECT_EQ(report["started"], "2026-11-24T09:30:00Z");
  EXPECT_EQ(report["host"], "first");
  EXPECT_EQ(report["preset"], "balanced");
  EXPECT_EQ(report["state"], "unfinished");
  ASSERT_EQ(report["stages"].size(), 2u);
  EXPECT_EQ(report["stages"][1]["seconds"], 60);
  EXPECT_EQ(report["seconds"]["command"], 63.5);
  EXPECT_TRUE(report["seconds"]["training"].is_null());
  EXPECT_EQ(report["steps"], 100);
  EXPECT_EQ(report["size"]["static"], 950);
  EXPECT_EQ(report["size"]["peak_bytes"], 100000);
  const json& curves = report["curves"];
  EXPECT_EQ(curves["loss"]["step"], json::parse("[50, 100]"));
  EXPECT_EQ(curves["loss"]["value"], json::parse("[0.3, 0.2]"));
  EXPECT_EQ(curves["psnr_test"]["value"], json::parse("[22.5]"));
  EXPECT_EQ(curves["psnr_validation"]["step"], json::parse("[60]"));
  EXPECT_EQ(curves["memory"]["value"][1], 100000);
}

// Bug put back: seconds of a line are those of one step; a resumed training begins at 0 seconds;
// seen to fail.
TEST(RunReport, CurvesHaveTheSecondsOfStepsAndDecisions) {
  RunRecords records;
  json first = steps(50, 0.3, 900), second = steps(100, 0.2, 950), third = steps(120, 0.1, 950);
  first["seconds_per_step"] = 0.01;
  second["seconds_per_step"] = third["seconds_per_step"] = 0.02;
  const json decision = {{"event", "decision"}, {"iteration", 60}, {"decision_seconds", 2.0}};
  records.log = lines({start(0, "a"), first, decision, second, start(100, "b"), third});
  const json seconds = run_report(records)["curves"]["loss"]["seconds"];
  ASSERT_EQ(seconds.size(), 3u);
  EXPECT_NEAR(seconds[0], 0.5, 1e-9);
  EXPECT_NEAR(seconds[1], 0.5 + 2 + 1, 1e-9);
  EXPECT_NEAR(seconds[2], 0.5 + 2 + 1 + 0.4, 1e-9);
}

// Bug put back: all lines of the log count, so that a resumed training goes back in its curves;
// seen to fail.
TEST(RunReport, AResumedTrainingHasEachStepOnce) {
  RunRecords records = usual_records();
  records.log += lines({start(50, "second"), steps(100, 0.25, 940), steps(150, 0.1, 960)});
  const json report = run_report(records);
  EXPECT_EQ(report["curves"]["loss"]["step"], json::parse("[50, 100, 150]"));
  EXPECT_EQ(report["curves"]["loss"]["value"], json::parse("[0.3, 0.25, 0.1]"));
  EXPECT_TRUE(report["curves"]["psnr_test"]["step"].empty()) << "of a step that was trained again";
  EXPECT_EQ(report["host"], "second");
  EXPECT_EQ(report["initial_points"], "first");
  EXPECT_EQ(report["warnings"].size(), 2u) << "warnings stay";
  EXPECT_TRUE(report["seconds"]["command"].is_null())
      << "those of one session are not those of all";
}

// Bug put back: a warning that each start repeats is listed each time; seen to fail.
TEST(RunReport, WarningsHaveTheirStageAndAreListedOnce) {
  RunRecords records = usual_records();
  records.log += lines({start(50, "b"), {{"event", "warning"}, {"text", "few views"}}});
  const json report = run_report(records);
  ASSERT_EQ(report["warnings"].size(), 2u);
  EXPECT_EQ(report["warnings"][0]["stage"], "ingest");
  EXPECT_EQ(report["warnings"][0]["text"], "cam03 is dark");
  EXPECT_EQ(report["warnings"][1]["stage"], "train");
}

// Bug put back: pruning towards a size limit explained by the price of a byte; seen to fail.
TEST(RunReport, DecisionsAreSentencesWithNumbersAndReasons) {
  RunRecords records = usual_records();
  json decision = {{"event", "decision"},
                   {"iteration", 200},
                   {"demoted", 9107},
                   {"promoted", 1},
                   {"spawned", 0},
                   {"spawned_missed", 4200},
                   {"removed", 1200},
                   {"goal", 0},
                   {"knee", 700},
                   {"price", 0.0197},
                   {"psnr", 28.104},
                   {"thinned", 28.02},
                   {"static_before", 8289},
                   {"dynamic_before", 10611},
                   {"static", 16000},
                   {"dynamic", 1504},
                   {"degrees", {0, 0, 0, 0}}};
  records.log += lines({decision});
  const std::string text = text_of(run_report(records));
  for (const char* part : {"200: 9,107 dynamic Gaussians were demoted to static, because",
                           "1 static Gaussian was promoted",
                           "4,200 dynamic Gaussians were added where several cameras",
                           "1,200 Gaussians were pruned, each of which lowered",
                           "less than 0.02 for every byte", "28.10 dB before, 28.02 dB after"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  EXPECT_EQ(text.find("spawned"), std::string::npos);
  EXPECT_EQ(run_report(records)["decisions"][0]["static"], json({8289, 16000}));

  decision["goal"] = 40'000;
  records.log += lines({decision});
  const std::string limited = text_of(run_report(records));
  EXPECT_NE(limited.find("the size limit of 40,000 Gaussians"), std::string::npos) << limited;
  for (const char* none : {"demoted", "promoted", "removed", "spawned_missed"}) decision[none] = 0;
  records.log = lines({decision});
  EXPECT_NE(text_of(run_report(records)).find("nothing was changed"), std::string::npos);
}

TEST(RunReport, DensityControlIsOneSentenceASet) {
  RunRecords records = usual_records();
  for (const int64_t step : {100, 200, 300})
    records.log += lines({{{"event", "density"},
                           {"iteration", step},
                           {"set", "static"},
                           {"cloned", 1000},
                           {"split", 20},
                           {"pruned", 3}}});
  const std::string text = text_of(run_report(records));
  EXPECT_NE(text.find("100: Density control of the static set from step 100 on: 3,000 cloned, 60 "
                      "split, 9 pruned"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("dynamic set"), std::string::npos);
}

// Bugs put back: the score of `evaluate` is no point of the curve; it is one besides that of the
// training; each seen to fail.
TEST(RunReport, TheScoreOfEvaluateEndsTheCurve) {
  RunRecords records = usual_records();
  records.log = lines({start(0, "first"), steps(50, 0.3, 900), steps(100, 0.2, 950)});
  records.metrics = {{"split", "test"}, {"psnr", 28.3}};
  records.trained = {{"iterations", 100}, {"seconds", 4.5}};
  const json expected = {{"step", {100}}, {"seconds", {4.5}}, {"value", {28.3}}};
  EXPECT_EQ(run_report(records)["curves"]["psnr_test"], expected);
  records.log += lines(
      {{{"event", "evaluation"}, {"iteration", 100}, {"splits", {{"test", {{"psnr", 22.5}}}}}}});
  EXPECT_EQ(run_report(records)["curves"]["psnr_test"]["value"], json::array({22.5}));
  records.metrics["split"] = "train";
  records.log = lines({start(0, "first"), steps(100, 0.2, 950)});
  EXPECT_EQ(run_report(records)["curves"]["psnr_test"]["value"], json::array());
}

TEST(RunReport, ScoresHaveMovingAndStaticPixelsApart) {
  RunRecords records = usual_records();
  records.metrics = json::parse(R"({"split": "test", "psnr": 28.314, "psnr_dynamic": 21.5,
      "psnr_static": 30.05, "ssim": null, "num_static": 7, "num_dynamic": 3, "timesteps": [1, 2],
      "worst_timestep": {"psnr": 25.1, "frame_number": 4},
      "objects": [{"name": "ball", "psnr": 19.5}],
      "per_view": [{"name": "test/a", "camera": "cam00", "psnr": 28.0, "psnr_dynamic": null}]})");
  const json report = run_report(records);
  EXPECT_EQ(report["scores"]["psnr"], 28.314);
  EXPECT_EQ(report["scores"]["psnr_dynamic"], 21.5);
  EXPECT_EQ(report["scores"]["psnr_static"], 30.05);
  EXPECT_TRUE(report["scores"]["ssim"].is_null());
  EXPECT_EQ(report["verdict"], "sharp where it stands still, soft where it moves");
  EXPECT_EQ(report["worst"], (json{{"frame_number", 4}, {"psnr", 25.1}}));
  EXPECT_EQ(report["objects"][0]["name"], "ball");
  EXPECT_EQ(report["size"]["static"], 7) << "of the model that was scored";
  ASSERT_EQ(report["views"].size(), 1u);
  EXPECT_EQ(report["views"][0]["camera"], "cam00");
  EXPECT_TRUE(report["views"][0]["psnr_dynamic"].is_null());
}

// Bug put back: fields read with json::value, which throws where a field has another type; seen to
// fail.
TEST(RunReport, DamagedAndMissingRecordsLeaveGaps) {
  EXPECT_TRUE(run_report({})["scores"]["psnr"].is_null());
  RunRecords records;
  records.config = {{"preset", 7}};
  records.metrics = {{"psnr", "high"}, {"per_view", 3}, {"split", nullptr}};
  records.stages = json::array({1});
  records.log =
      "{\"event\": \"steps\", \"iteration\": \"x\", \"loss\": []}\nno json\n[1]\n\n{\"event\":5}";
  const json report = run_report(records);
  EXPECT_EQ(report["preset"], "");
  EXPECT_EQ(report["cameras"], json::array());
  EXPECT_TRUE(report["curves"]["loss"]["step"].empty());
  EXPECT_TRUE(report["views"].empty());
}

}  // namespace
}  // namespace tessera
