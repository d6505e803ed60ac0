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
  EXPECT_EQ(ingest().warnings.size(), 1u);
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

}  // namespace
}  // namespace tessera
