// The table of cameras of rigs made by hand: what is odd, which camera to leave out, and that text
// and JSON state the same.
#include "ingest/checks/camera_table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/camera_table_text.h"
#include "ingest/capture/capture.h"

namespace tessera {
namespace {

using Notes = std::vector<std::string>;
using nlohmann::json;

/// Cameras of 64×48 with 24 frames/s, all 12 frames in the scene; the first is held out.
Capture rig_of(int cameras) {
  Capture capture;
  for (int c = 0; c < cameras; ++c) {
    RigClip& clip = capture.clips.emplace_back();
    clip.name = fmt::format("cam{:02}", c);
    clip.timeline.width = 64;
    clip.timeline.height = 48;
    clip.timeline.frame_seconds = 1 / 24.0;
    clip.camera = RigCamera{clip.name, {}, {}, "PINHOLE", true, 0.25};
    CaptureCamera& camera = capture.cameras.emplace_back();
    camera.name = clip.name;
    camera.time_source = "stated";
    capture.held_out.push_back(c == 0);
    for (int k = 0; k < 12; ++k) {
      clip.timeline.ticks.push_back(k);
      capture.frames.emplace_back().frame.camera_name = clip.name;
    }
  }
  capture.clips.front().camera->reprojection_error.reset();
  return capture;
}

/// cam01 has 30 frames/s, cam02 half of the frames and another size, cam03 an offset of two frames,
/// cam04 a pose that is off.
std::vector<CameraRow> odd_rows() {
  Capture capture = rig_of(10);
  capture.clips[1].timeline.frame_seconds = 1 / 30.0;
  capture.clips[2].timeline.ticks.resize(6);
  capture.clips[2].timeline.width = 32;
  capture.partial = {"cam02"};
  capture.cameras[3].time_offset = -2 / 24.0;
  capture.cameras[3].time_uncertainty = 0.25 / 24;
  capture.cameras[3].time_source = "motion";
  capture.clips[3].camera->camera.readout = 0.016;
  capture.clips[4].camera->reprojection_error = 1.5;
  return camera_table(capture);
}

// Bug put back: the offset in frames is that in seconds; seen to fail.
TEST(CameraTable, OddCamerasAreMarkedAndTheOthersAreListed) {
  const std::vector<CameraRow> rows = odd_rows();
  ASSERT_EQ(rows.size(), 10u);
  EXPECT_TRUE(rows[0].test);
  EXPECT_FALSE(rows[0].is_odd() || rows[3].is_odd());
  EXPECT_EQ(rows[1].notes, Notes{"other rate"});
  EXPECT_NEAR(rows[1].frames_per_second, 30, 1e-9);
  EXPECT_EQ(rows[2].notes, (Notes{"other size", "part of the clip"}));
  EXPECT_EQ(rows[2].frames_in_file, 6);
  EXPECT_EQ(rows[2].frames_kept, 12);
  EXPECT_NEAR(rows[3].clock_offset_frames, -2, 1e-9);
  EXPECT_EQ(rows[4].notes, Notes{"large pose error"});
  EXPECT_EQ(leave_out_line(rows),
            "leave out cam01 (other rate), cam04 (large pose error): --cameras "
            "cam00,cam02,cam03,cam05,cam06,cam07,cam08,cam09");
  Capture sizes = rig_of(3);
  sizes.clips[1].timeline.height = 36;
  EXPECT_EQ(camera_table(sizes)[1].notes, Notes{"other size"});
  EXPECT_EQ(leave_out_line(camera_table(sizes)), "");
}

TEST(CameraTable, NothingIsOddOfOneCameraAndOfCamerasThatAreAlike) {
  EXPECT_TRUE(camera_table(rig_of(1)).empty());
  EXPECT_TRUE(camera_table({}).empty());
  for (const CameraRow& row : camera_table(rig_of(4))) EXPECT_FALSE(row.is_odd()) << row.name;
}

TEST(CameraTable, AClockIsUnknownWhereOthersHaveOne) {
  Capture capture = rig_of(4);
  for (CaptureCamera& camera : capture.cameras) camera.time_source = "none";
  EXPECT_EQ(leave_out_line(camera_table(capture)), "");
  capture.cameras[0].time_source = "motion";
  EXPECT_EQ(camera_table(capture)[1].notes, Notes{"clock unknown"});
  EXPECT_EQ(leave_out_line(camera_table(capture)), "") << "nothing speaks against it";
}

TEST(CameraTable, NoCameraIsLeftOutWhereFewWouldStay) {
  for (const size_t count : {6, 7}) {
    Capture capture = rig_of(int(count));
    capture.clips[3].timeline.frame_seconds = 1 / 30.0;
    EXPECT_EQ(leave_out_line(camera_table(capture)),
              count == 6 ? ""
                         : "leave out cam03 (other rate): --cameras "
                           "cam00,cam01,cam02,cam04,cam05,cam06");
  }
}

TEST(CameraTable, DarkAndTurnedCamerasAreMarkedAndStay) {
  std::vector<CameraRow> rows = camera_table(rig_of(4));
  put_gains({{"cam01", {0.5, 0.6, 0.7}, 100}, {"cam02", {0.1, 0.1, 0.1}, 3}, {"none", {}, 100}},
            rows);
  put_rolls({{"cam02", -91, true}, {"cam03", 180, false}}, rows);
  EXPECT_NEAR(rows[1].gain.value_or(0), 0.6, 1e-9);
  EXPECT_EQ(rows[1].notes, Notes{"dark"});
  EXPECT_FALSE(rows[2].gain);
  EXPECT_EQ(rows[2].notes, Notes{"turned"});
  EXPECT_FALSE(rows[3].roll);
  EXPECT_EQ(leave_out_line(rows), "");
}

// Bug put back: the offset in frames is that in seconds; seen to fail.
TEST(CameraTableText, TextAndJsonStateTheSame) {
  std::vector<CameraRow> rows = odd_rows();
  put_gains({{"cam03", {0.5, 0.5, 0.5}, 100}}, rows);
  put_rolls({{"cam03", 3, true}}, rows);
  const std::vector<std::string> lines = camera_table_lines(rows);
  const json table = camera_table_json(rows);
  ASSERT_EQ(lines.size(), 11u);
  ASSERT_EQ(table.size(), 10u);
  EXPECT_TRUE(lines[0].starts_with("  camera  size "));
  EXPECT_EQ(
      lines[4],
      "! cam03   64x48  24   12/12   0.25     -0.0833 (-2.00±0.25)  motion  0.50  3°    train  "
      "dark");
  EXPECT_EQ(table[3], (json{{"name", "cam03"},
                            {"width", 64},
                            {"height", 48},
                            {"frames_per_second", 24.0},
                            {"frames_in_file", 12},
                            {"frames_kept", 12},
                            {"pose_source", "COLMAP"},
                            {"pose_error_px", 0.25},
                            {"clock_offset_s", -2 / 24.0},
                            {"clock_offset_frames", -2 / 24.0 / (1 / 24.0)},
                            {"clock_error_frames", 0.25},
                            {"clock_source", "motion"},
                            {"readout_s", 0.016},
                            {"gain", 0.5},
                            {"roll_degrees", 3.0},
                            {"role", "train"},
                            {"leave_out", false},
                            {"notes", {"dark"}}}));
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(lines[i + 1].starts_with("! "), !table[i]["notes"].empty()) << lines[i + 1];
    const std::string frames = fmt::format(" {}/{} ", table[i]["frames_kept"].get<int>(),
                                           table[i]["frames_in_file"].get<int>());
    for (const std::string& part :
         {table[i]["name"].get<std::string>(), frames, table[i]["role"].get<std::string>()})
      EXPECT_NE(lines[i + 1].find(part), std::string::npos) << part << "\n" << lines[i + 1];
    EXPECT_LE(lines[i + 1].size(), 120u);
  }
  EXPECT_TRUE(table[0]["pose_error_px"].is_null()) << "a held-out camera gives no points";
}

TEST(CameraTableText, OfManyCamerasTheOddOnesAreShown) {
  Capture capture = rig_of(60);
  capture.clips[50].timeline.frame_seconds = 1 / 30.0;
  const std::vector<std::string> lines = camera_table_lines(camera_table(capture));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[1].starts_with("! cam50 ")) << lines[1];
  EXPECT_EQ(lines[2], "  and 59 cameras in which nothing is odd");
  EXPECT_TRUE(camera_table_lines({}).empty());
}

}  // namespace
}  // namespace tessera
