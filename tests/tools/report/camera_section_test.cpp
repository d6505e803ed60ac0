// The cameras of a run in its report: the same cells as on the terminal, from what the run stored.
#include "tools/report/camera_section.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/camera_table_text.h"
#include "tools/report/run_report.h"

namespace tessera {
namespace {

using nlohmann::json;

std::vector<CameraRow> two_rows() {
  CameraRow odd;
  odd.name = "cam<1>";
  odd.width = 1280;
  odd.height = 720;
  odd.frames_per_second = 30;
  odd.frames_in_file = 300;
  odd.frames_kept = 290;
  odd.pose_source = "COLMAP";
  odd.pose_error = 0.31;
  odd.clock_offset = -0.05;
  odd.clock_offset_frames = -1.5;
  odd.clock_source = "audio";
  odd.gain = 0.7;
  odd.roll = -2;
  odd.leave_out = true;
  odd.notes = {"other rate", "dark"};
  CameraRow test;
  test.name = "cam2";
  test.pose_source = "stated";
  test.test = true;
  return {odd, test};
}

// Bug put back: the key of the roll misspelt; seen to fail.
TEST(CameraSection, HasTheCellsOfTheTerminalFromWhatIsStored) {
  RunRecords records;
  const json table = camera_table_json(two_rows());
  records.stages = {{"ingest", {{"result", {{"camera_table", table}}}}}};
  const RunReport report = run_report(records);
  EXPECT_EQ(to_json(report)["camera_table"], table) << "read back without a loss";
  ASSERT_EQ(report.cameras.size(), 2u);
  EXPECT_TRUE(report.cameras[0].leave_out);
  const std::string html = camera_section(report.cameras);
  const auto rows = two_rows();
  for (const CameraRow& row : rows)
    for (const std::string& cell : camera_cells(row)) {
      const std::string shown = cell == "cam<1>" ? "cam&lt;1&gt;" : cell;
      EXPECT_NE(html.find("<td>" + shown + "</td>"), std::string::npos) << cell;
    }
  EXPECT_NE(html.find("<div class=\"wide\">"), std::string::npos) << "scrolls in its box";
  EXPECT_NE(html.find("<tr class=\"odd\"><td>cam&lt;1&gt;"), std::string::npos);
  EXPECT_EQ(html.find("<tr class=\"odd\"><td>cam2"), std::string::npos);
}

TEST(CameraSection, DamagedAndMissingTablesLeaveGaps) {
  EXPECT_EQ(camera_section({}), "");
  EXPECT_TRUE(camera_rows(nullptr).empty());
  EXPECT_TRUE(camera_rows({{"name", "cam0"}}).empty());
  const std::vector<CameraRow> rows =
      camera_rows(json::array({1, {{"name", 7}, {"notes", {2, "dark"}}, {"gain", "high"}}}));
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].name, "");
  EXPECT_FALSE(rows[0].gain);
  EXPECT_EQ(rows[0].notes, std::vector<std::string>{"dark"});
}

}  // namespace
}  // namespace tessera
