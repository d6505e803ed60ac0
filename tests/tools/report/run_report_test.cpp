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
  return {{"event", "start"}, {"iteration", step}, {"time", "2026-11-24T09:30:00Z"},
          {"host", host},     {"cpu", "A CPU"},    {"command", {"/opt/tessera", "run", "my room"}}};
}

RunRecords usual_records() {
  RunRecords records;
  records.config = {{"tessera", "0.1.0"}, {"preset", "balanced"}, {"device", "CPU"}};
  records.stages = {{"ingest", {{"seconds", 3.5}, {"result", {{"warnings", {"cam03 is dark"}}}}}},
                    {"train", {{"seconds", 60.0}}}};
  records.log = lines(
      {start(0, "first"),
       {{"event", "warning"}, {"text", "few views"}},
       steps(50, 0.3, 900),
       {{"event", "validation"}, {"iteration", 60}, {"psnr", 21.5}},
       steps(100, 0.2, 950),
       {{"event", "evaluation"}, {"iteration", 100}, {"splits", {{"test", {{"psnr", 22.5}}}}}}});
  return records;
}

std::string text_of(const RunReport& report) {
  std::string text;
  for (const RunDecision& decision : report.decisions)
    text += std::to_string(decision.step) + ": " + decision.text + "\n";
  return text;
}

// Bug put back: a quote in a word ends the quotes around it; seen to fail.
TEST(RunReport, TheCommandCanBeTypedAgain) {
  RunRecords records;
  json event = start(0, "a");
  event["command"] = {"tessera", "run", "it's", ""};
  records.log = lines({event});
  EXPECT_EQ(run_report(records).command, "tessera run 'it'\\''s' ''");
}

TEST(RunReport, HasMachineStagesAndCurves) {
  const RunReport report = run_report(usual_records());
  EXPECT_EQ(report.command, "tessera run 'my room'");
  EXPECT_EQ(report.started, "2026-11-24T09:30:00Z");
  EXPECT_EQ(report.host, "first");
  EXPECT_EQ(report.preset, "balanced");
  ASSERT_EQ(report.stages.size(), 2u);
  EXPECT_EQ(report.stages[1].seconds, 60);
  EXPECT_EQ(report.steps, 100);
  EXPECT_EQ(report.num_static, 950);
  const json curves = to_json(report)["curves"];
  EXPECT_EQ(curves["loss"], json::parse("[[50, 0.3], [100, 0.2]]"));
  EXPECT_EQ(curves["psnr_test"], json::parse("[[100, 22.5]]"));
  EXPECT_EQ(curves["psnr_validation"], json::parse("[[60, 21.5]]"));
  EXPECT_EQ(curves["bytes"][1][1], 100000);
}

// Bug put back: all lines of the log count, so that a resumed training goes back in its curves;
// seen to fail.
TEST(RunReport, AResumedTrainingHasEachStepOnce) {
  RunRecords records = usual_records();
  records.log += lines({start(50, "second"), steps(100, 0.25, 940), steps(150, 0.1, 960)});
  const RunReport report = run_report(records);
  EXPECT_EQ(to_json(report)["curves"]["loss"], json::parse("[[50, 0.3], [100, 0.25], [150, 0.1]]"));
  EXPECT_TRUE(report.curves.psnr_test.empty()) << "of a step that was trained again";
  EXPECT_EQ(report.host, "second");
  EXPECT_EQ(report.warnings.size(), 2u) << "warnings stay";
}

// Bug put back: a warning that each start repeats is listed each time; seen to fail.
TEST(RunReport, WarningsHaveTheirStageAndAreListedOnce) {
  RunRecords records = usual_records();
  records.log += lines({start(50, "b"), {{"event", "warning"}, {"text", "few views"}}});
  const RunReport report = run_report(records);
  ASSERT_EQ(report.warnings.size(), 2u);
  EXPECT_EQ(report.warnings[0].stage, "ingest");
  EXPECT_EQ(report.warnings[0].text, "cam03 is dark");
  EXPECT_EQ(report.warnings[1].stage, "train");
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
                           "less than 0.02 for every byte", "28.10 dB before, 28.02 dB after",
                           "had 8,289 static and 10,611 dynamic", "has 16,000 and 1,504"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  EXPECT_EQ(text.find("spawned"), std::string::npos);

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

TEST(RunReport, ScoresHaveMovingAndStaticPixelsApart) {
  RunRecords records = usual_records();
  records.metrics = {
      {"split", "test"},
      {"psnr", 28.314},
      {"psnr_dynamic", 21.5},
      {"psnr_static", 30.05},
      {"ssim", nullptr},
      {"num_static", 7},
      {"num_dynamic", 3},
      {"timesteps", {1, 2}},
      {"worst_timestep", {{"psnr", 25.1}, {"frame_number", 4}}},
      {"objects", {{{"name", "ball"}, {"psnr", 19.5}}}},
      {"per_view",
       {{{"name", "test/a"}, {"camera", "cam00"}, {"psnr", 28.0}, {"psnr_dynamic", nullptr}}}}};
  const RunReport report = run_report(records);
  const json scores = to_json(report)["scores"];
  EXPECT_EQ(scores["PSNR"], "28.31 dB");
  EXPECT_EQ(scores["PSNR of moving pixels"], "21.50 dB");
  EXPECT_EQ(scores["PSNR of static pixels"], "30.05 dB");
  EXPECT_EQ(scores["Lowest timestep (frame 4)"], "25.10 dB");
  EXPECT_EQ(scores["ball"], "19.50 dB");
  EXPECT_FALSE(scores.contains("SSIM"));
  EXPECT_EQ(report.num_static, 7) << "of the model that was scored";
  ASSERT_EQ(report.views.size(), 1u);
  EXPECT_EQ(report.views[0].camera, "cam00");
  EXPECT_FALSE(report.views[0].psnr_dynamic.has_value());
}

// Bug put back: fields read with json::value, which throws where a field has another type; seen to
// fail.
TEST(RunReport, DamagedAndMissingRecordsLeaveGaps) {
  EXPECT_TRUE(run_report({}).scores.empty());
  RunRecords records;
  records.config = {{"preset", 7}};
  records.metrics = {{"psnr", "high"}, {"per_view", 3}, {"split", nullptr}};
  records.stages = json::array({1});
  records.log =
      "{\"event\": \"steps\", \"iteration\": \"x\", \"loss\": []}\nno json\n[1]\n\n{\"event\":5}";
  const RunReport report = run_report(records);
  EXPECT_EQ(report.preset, "");
  EXPECT_TRUE(report.curves.loss.empty());
  EXPECT_TRUE(report.views.empty());
}

}  // namespace
}  // namespace tessera
