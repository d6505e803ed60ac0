// The data of the report of a clip in windows, from files written here.
#include <gtest/gtest.h>

#include "ingest/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tools/report/run_report.h"

namespace tessera {
namespace {

using nlohmann::json;

/// The log of a window: a warning of its own and one of all, 100 steps, and where it is done its
/// end.
std::string log_of(int index, bool is_done, int64_t first = 0) {
  std::vector<json> events = {
      {{"event", "start"}, {"iteration", first}, {"command", {"tessera", "run", "room"}}},
      {{"event", "warning"}, {"text", "few views"}},
      {{"event", "warning"}, {"text", "window " + std::to_string(index)}},
      {{"event", "steps"},
       {"iteration", 100},
       {"loss", 0.3},
       {"num_static", 900},
       {"num_dynamic", 50},
       {"peak_device_bytes", 1000 * (3 - index)}},
      {{"event", "decision"}, {"iteration", 100}}};
  if (is_done)
    events.push_back({{"event", "end"},
                      {"iterations", 100},
                      {"seconds", 4.5},
                      {"bytes", 700},
                      {"num_static", 900},
                      {"num_dynamic", 40 + index}});
  std::string log;
  for (const json& event : events) log += event.dump() + "\n";
  return log;
}

/// Two windows of 2.5 s each; views at every second and at both ends, the later the better.
class WindowsReport : public ::testing::Test {
 protected:
  WindowsReport() {
    write("windows.json", {{"time", {{"origin", 0}, {"duration", 5}}},
                           {"windows",
                            {{{"folder", "windows/0000"}, {"drawn", {0, 0.5}}},
                             {{"folder", "windows/0001"}, {"drawn", {0.5, 1}}}}}});
    write("windows/0000/config.json", {{"preset", "fast"}, {"tessera", "0.3"}, {"device", "cpu"}});
    write_log(0, true);
    write_log(1, true);
    json views = json::array();
    for (const double time : {0.0, 0.2, 0.5, 0.8, 1.0})
      views.push_back({{"name", "a"}, {"camera", "cam00"}, {"time", time}, {"psnr", 20 + time}});
    views[4]["psnr_dynamic"] = 15.5;
    write("metrics.json", {{"psnr", 20.5},
                           {"per_view", views},
                           {"num_static", 900},
                           {"num_dynamic", 81},
                           {"borders", {{"inside", 2.0}, {"border", 3.0}}}});
  }
  void write(const std::string& file, const json& content) const {
    make_folder((folder / file).parent_path());
    write_text_file(folder / file, content.dump());
  }
  void write_log(int index, bool is_done, int64_t first = 0) const {
    const auto run = folder / ("windows/000" + std::to_string(index));
    make_folder(run);
    write_text_file(run / "log.jsonl", log_of(index, is_done, first));
  }
  json report(json stages = nullptr) const {
    RunRecords records = read_records(folder.path());
    records.stages = std::move(stages);
    return run_report(records);
  }

  testing::ScratchFolder folder;
};

// Bugs put back, each seen to fail: a view on a border counts in both windows; the last timestep in
// none; sizes and steps of the first window alone; curves of the first window as those of the clip.
TEST_F(WindowsReport, HasEachWindowAndTheirSums) {
  const json run = report();
  EXPECT_EQ(run["scores"]["psnr"], 20.5);
  ASSERT_EQ(run["windows"].size(), 2u);
  const json &first = run["windows"][0], &second = run["windows"][1];
  EXPECT_DOUBLE_EQ(first["psnr"], 20.1);
  EXPECT_TRUE(first["psnr_dynamic"].is_null());
  EXPECT_DOUBLE_EQ(second["psnr"], 20 + 2.3 / 3);
  EXPECT_EQ(second["psnr_dynamic"], 15.5);
  EXPECT_EQ(second["begin"], 2.5);
  EXPECT_EQ(second["end"], 5);
  EXPECT_EQ(second["dynamic"], 41);
  EXPECT_EQ(run["steps"], 200);
  EXPECT_EQ(run["size"]["static"], 900);
  EXPECT_EQ(run["size"]["dynamic"], 81);
  EXPECT_EQ(run["size"]["model_bytes"], 1400);
  EXPECT_EQ(run["size"]["peak_bytes"], 3000) << "the most of a window";
  EXPECT_EQ(run["seconds"]["training"], 9);
  EXPECT_EQ(run["state"], "done");
  EXPECT_EQ(run["borders"]["border"], 3);
  EXPECT_EQ(run["preset"], "fast");
  EXPECT_EQ(run["version"], "0.3");
  EXPECT_EQ(run["command"], "tessera run room");
  EXPECT_TRUE(run["curves"]["loss"]["step"].empty());
  EXPECT_TRUE(run["decisions"].empty());
  ASSERT_EQ(run["warnings"].size(), 3u) << "of both, those of one text once";
  EXPECT_EQ(run["warnings"][2]["text"], "window 1");
}

// Bug put back: the training of what stands still left out; seen to fail.
TEST_F(WindowsReport, CountsTheStaticTraining) {
  make_folder(folder / "static");
  write_text_file(folder / "static/log.jsonl", log_of(7, true));
  json plan = json::parse(read_text_file(folder / "windows.json"));
  plan["static"] = "static";
  write("windows.json", plan);
  const json run = report();
  EXPECT_EQ(run["steps"], 300);
  EXPECT_EQ(run["seconds"]["training"], 13.5);
  EXPECT_EQ(run["size"]["dynamic"], 81) << "of windows";
}

// Bug put back: the seconds of a command that went on with the windows of an earlier one, or
// resumed a later window, count as those of the whole; seen to fail.
TEST_F(WindowsReport, ACommandThatWentOnHasNoSecondsOfTheWhole) {
  const auto command = [&](bool continued) {
    return report(
        {{"ingest", {{"seconds", 2.0}}},
         {"train",
          {{"seconds", 10.0}, {"result", {{"continued", continued}}}}}})["seconds"]["command"];
  };
  EXPECT_EQ(command(false), 12);
  EXPECT_TRUE(command(true).is_null());
  write_log(1, true, 50);
  EXPECT_TRUE(command(false).is_null());
}

TEST_F(WindowsReport, AnUnfinishedOrMissingWindowLeavesGaps) {
  write_log(1, false);
  json run = report();
  EXPECT_EQ(run["state"], "unfinished");
  EXPECT_TRUE(run["seconds"]["training"].is_null());
  EXPECT_EQ(run["windows"][1]["steps"], 100);
  EXPECT_EQ(run["windows"][1]["dynamic"], 50);
  std::filesystem::remove(folder / "windows/0001/log.jsonl");
  std::filesystem::remove(folder / "metrics.json");
  run = report();
  EXPECT_EQ(run["windows"][1]["steps"], 0);
  EXPECT_TRUE(run["windows"][0]["psnr"].is_null());
  EXPECT_TRUE(run["borders"].is_null());
  write("windows.json", {{"windows", 7}});
  EXPECT_FALSE(report().contains("windows")) << "is damaged";
}

}  // namespace
}  // namespace tessera
