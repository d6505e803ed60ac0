// Rigs of videos with a file of cameras: cameras without a pose, and lenses whose distortion cannot
// be removed.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/ingest.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

/// Eight videos of 32×24 and their cameras: so many that there is no warning of few.
class RigOfVideos : public ::testing::Test {
 protected:
  static constexpr int kCameras = 8;
  void SetUp() override {
    if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
    std::filesystem::create_directories(folder_ / "capture");
    for (int c = 0; c < kCameras; ++c) {
      const std::string name = fmt::format("cam{:02}", c);
      write_video(folder_ / ("capture/" + name + ".mp4"), numbered_video(4, c));
      cameras_.push_back(
          {{"name", name},
           {"transform_matrix", gl_matrix(looking_at_origin({4.0, 0.5 * c - 1.5, 1.0}))},
           {"fl_x", 50},
           {"fl_y", 50},
           {"cx", 16},
           {"cy", 12},
           {"w", 32},
           {"h", 24}});
    }
  }
  IngestReport ingest(bool strict = false) {
    write_bytes(folder_ / "cameras.json", json{{"cameras", cameras_}}.dump());
    IngestOptions options;
    options.poses.source = {PoseSource::kCameras, folder_ / "cameras.json"};
    options.strict = strict;
    options.sync.method = SyncMethod::kNone;
    options.cloud = CloudDensity::kNone;
    decoded_ = false;
    return ingest_capture(folder_ / "capture", folder_ / "scene", options,
                          [&](std::string_view what, int64_t, int64_t) {
                            decoded_ = decoded_ || what.starts_with("decoding");
                          });
  }
  /// Refused before any frame is decoded, and nothing is left but the capture and its cameras.
  void expect_refused(bool strict, const std::vector<std::string>& parts) {
    expect_input_error([&] { ingest(strict); }, parts);
    EXPECT_FALSE(decoded_);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 2);
  }
  /// The scene has all cameras but this one.
  void expect_without(const std::string& camera) const {
    std::set<std::string> names;
    for (const Frame& frame : load_scene(folder_ / "scene", {}).frames)
      names.insert(frame.camera_name);
    EXPECT_EQ(names.size(), size_t(kCameras - 1));
    EXPECT_FALSE(names.contains(camera));
  }

  TemporaryFolder folder_;
  json cameras_ = json::array();
  bool decoded_ = false;
};

// A calibration of the images as they are shown, of anamorphic video. Bugs put back, each seen to
// fail: refused as another shape; no word about it.
TEST_F(RigOfVideos, AnamorphicVideoKeepsItsPixels) {
  for (int c = 0; c < kCameras; ++c) {
    TestVideo video = numbered_video(4, c);
    video.pixel_aspect = {4, 3};
    write_video(folder_ / fmt::format("capture/cam{:02}.mp4", c), video);
  }
  for (json& camera : cameras_) {
    camera["w"] = 43;
    camera["cx"] = 21.5;
  }
  const IngestReport report = ingest();
  const Scene scene = load_scene(folder_ / "scene", {});
  ASSERT_EQ(scene.frames[0].camera.width, 32);
  EXPECT_NEAR(scene.frames[0].camera.fl_x, 50 * 32 / 43.0, 1e-9);
  EXPECT_NEAR(scene.frames[0].camera.fl_y, 50, 1e-9);
  EXPECT_NEAR(scene.frames[0].camera.cx, 16, 1e-9);
  EXPECT_TRUE(std::any_of(report.notes.begin(), report.notes.end(), [](const std::string& note) {
    return note.find("cam00, cam01, cam02") == 0 &&
           note.find("32x24 pixels that are 1.333 times as wide as high, shown as 43x24") !=
               std::string::npos;
  })) << fmt::format("{}", fmt::join(report.notes, "\n"));
}

// F14. Bugs put back: every missing camera refused; strict not asked for; one camera alone taken
// for a rig; each seen to fail.
TEST_F(RigOfVideos, AVideoWithoutAPoseIsLeftOutAndNamed) {
  cameras_.erase(2);
  const IngestReport report = ingest();
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(
      report.warnings[0].find("cameras.json: has no camera for cam02; it has cam00, cam01, cam03"),
      std::string::npos)
      << report.warnings[0];
  EXPECT_NE(report.warnings[0].find("the other 7 cameras"), std::string::npos);
  EXPECT_EQ(report.cameras, 7);
  expect_without("cam02");
  std::filesystem::remove_all(folder_ / "scene");
  expect_refused(true, {"no camera for cam02", "rename", "--strict"});
  while (cameras_.size() > 1) cameras_.erase(1);
  expect_refused(false, {"no camera for cam01, cam02, cam03, cam04", "rename"});
}

// Bugs put back: the lens checked when its video is converted; one bad lens stops all; each seen
// to fail.
TEST_F(RigOfVideos, ALensThatCannotBeRemovedIsLeftOutAndNamed) {
  cameras_[1]["k1"] = -5000;
  const IngestReport report = ingest();
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("cam01.mp4 (OPENCV): its lens distortion"), std::string::npos)
      << report.warnings[0];
  expect_without("cam01");
  std::filesystem::remove_all(folder_ / "scene");
  expect_refused(true, {"cam01.mp4", "turns back", "--cameras", "--strict"});
  for (int c = 1; c < kCameras; ++c) cameras_[size_t(c)]["k1"] = -5000;
  expect_refused(false, {"cam01.mp4", "likewise: cam01, cam02, cam03"});
}

// F15, with the coefficients of a sensor that was cropped to its upper part.
TEST_F(RigOfVideos, APrincipalPointOutsideOfTheImageIsTaken) {
  cameras_[7]["fl_x"] = cameras_[7]["fl_y"] = 32;
  cameras_[7]["cy"] = 36;
  cameras_[7]["k1"] = -0.27;
  cameras_[7]["k2"] = 0.19;
  EXPECT_TRUE(ingest(true).warnings.empty());
  const Scene scene = load_scene(folder_ / "scene", {});
  EXPECT_GT(scene.frames.back().camera.cy, 24);
}

// Bugs put back, each seen to fail: the colours of the clips not compared; the conversion not
// recorded.
TEST_F(RigOfVideos, ACameraOfOtherColoursIsConvertedRecordedAndNamed) {
  TestVideo hlg = numbered_video(4, 3);
  hlg.transfer = VideoTransfer::kHlg;
  write_video(folder_ / "capture/cam03.mp4", hlg);
  const IngestReport report = ingest();
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_TRUE(report.warnings[0].starts_with("cam03 is HLG, the others SDR: "))
      << report.warnings[0];
  const json scene = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(scene["tessera"]["applied"]["tone_map"], "hlg to srgb, 203 nits white");
}

// 25 and 50 frames/s, a short clip, and stated offsets.
TEST_F(RigOfVideos, TheTableNamesCamerasOfOtherRatesAndShortOnes) {
  for (int c = 0; c < kCameras; ++c)
    write_video(folder_ / fmt::format("capture/cam{:02}.mp4", c), numbered_video(10, c));
  TestVideo fast = numbered_video(20, 2);
  for (int64_t k = 0; k < 20; ++k) fast.ticks.push_back(k * kTestTicksPerFrame / 2);
  write_video(folder_ / "capture/cam02.mp4", fast);
  write_video(folder_ / "capture/cam05.mp4", numbered_video(7, 5));
  std::string offsets;
  for (int c = 0; c < kCameras; ++c) offsets += fmt::format("cam{:02} {}\n", c, c == 6 ? 0.04 : 0);
  write_bytes(folder_ / "cameras.json", json{{"cameras", cameras_}}.dump());
  write_bytes(folder_ / "offsets.txt", offsets);
  IngestOptions options;
  options.poses.source = {PoseSource::kCameras, folder_ / "cameras.json"};
  options.sync.offsets = folder_ / "offsets.txt";
  options.cloud = CloudDensity::kNone;
  const IngestReport report = ingest_capture(folder_ / "capture", folder_ / "scene", options, {});
  const std::vector<CameraRow>& rows = report.camera_table;
  ASSERT_EQ(rows.size(), size_t(kCameras));
  EXPECT_NEAR(rows[2].frames_per_second, 50, 1e-9);
  EXPECT_EQ(rows[2].notes, std::vector<std::string>{"other rate"});
  EXPECT_EQ(rows[5].notes, std::vector<std::string>{"limits the clip"});
  EXPECT_EQ(rows[5].frames_in_file, 7);
  EXPECT_EQ(rows[0].frames_kept, 6) << "of what all cameras share, as cam06 begins a frame late";
  EXPECT_EQ(rows[6].clock_source, "stated");
  EXPECT_NEAR(rows[6].clock_offset_frames, 1, 1e-9);
  EXPECT_EQ(rows[6].pose_source, "stated");
  EXPECT_TRUE(rows[3].test && !rows[0].test) << "the innermost";
  EXPECT_EQ(report.warnings.at(0),
            "leave out cam02 (other rate), cam05 (limits the clip): --cameras "
            "cam00,cam01,cam03,cam04,cam06,cam07");
  for (size_t i = 1; i < report.warnings.size(); ++i)
    EXPECT_EQ(report.warnings[i].find("--cameras"), std::string::npos) << report.warnings[i];
}

}  // namespace
}  // namespace tessera
