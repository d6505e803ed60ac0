// The scene checks that use features, on a textured rig: a rotated camera, changed exposure, blur,
// no texture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "ingest/checks/camera_warnings.h"
#include "ingest/checks/exposure.h"
#include "ingest/checks/feature_matches.h"
#include "ingest/checks/sharpness.h"
#include "ingest/derived/thinned_scene.h"
#include "ingest/ingest.h"
#include "tests/ingest/layouts/textured_rig.h"
#include "tests/support/data_folder.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

bool has(const Findings& findings, Severity severity, const std::string& check) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
    return finding.severity == severity && finding.check == check;
  });
}

void turn(Scene& scene, const std::string& name, double degrees, const glm::dvec3& axis) {
  const glm::dmat3 rotation = rotation_about(axis, degrees * 3.14159265358979 / 180);
  for (Frame& frame : scene.frames)
    if (frame.camera_name == name) {
      frame.camera.cam_from_world = rotation * frame.camera.cam_from_world;
      frame.camera.translation = rotation * frame.camera.translation;
    }
}

// B4 about every axis. Fails with the median over pairs replaced by the smallest of them.
TEST(FeatureChecks, TurnedCameraRanksWorst) {
  const Scene rig = textured_rig();
  const PoseCheck right = check_poses(match_stations(rig));
  EXPECT_FALSE(has(right.findings, Severity::kError, "poses"));
  EXPECT_FALSE(has(right.findings, Severity::kWarning, "poses"));
  EXPECT_FALSE(has(right.findings, Severity::kWarning, "texture"));
  for (const glm::dvec3& axis : {glm::dvec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    Scene scene = rig;
    turn(scene, "cam4", 1, axis);
    const PoseCheck check = check_poses(match_stations(scene));
    EXPECT_EQ(check.cameras.front().camera, "cam4") << axis.x << axis.y << axis.z;
  }
  Scene scene = rig;
  turn(scene, "cam4", 1, {1, 0, 0});
  EXPECT_TRUE(has(check_poses(match_stations(scene)).findings, Severity::kError, "poses"));
}

TEST(FeatureChecks, TurnedCameraOfStudioRanksWorst) {
  const std::filesystem::path studio = data_folder("studio");
  if (studio.empty()) GTEST_SKIP() << "no studio data";
  const ScratchFolder folder;
  IngestOptions options;
  options.sample = true;
  ingest_capture(studio, folder / "scene", options, {});
  Scene scene = thinned_scene(folder / "scene", {}).sample;
  EXPECT_FALSE(has(check_poses(match_stations(scene)).findings, Severity::kError, "poses"));
  turn(scene, "cam05", 1, {1, 0, 0});
  const PoseCheck check = check_poses(match_stations(scene));
  EXPECT_EQ(check.cameras.front().camera, "cam05");
  EXPECT_TRUE(has(check.findings, Severity::kError, "poses"));
}

// B14: no texture is never bad poses. Fails with cameras of unknown residual counted as 0 or as
// bad.
TEST(FeatureChecks, NoTextureIsNotBadPoses) {
  Scene scene = textured_rig();
  for (Frame& frame : scene.frames)
    std::fill(frame.image.data.begin(), frame.image.data.end(), 128);
  turn(scene, "cam4", 1, {1, 0, 0});
  const PoseCheck check = check_poses(match_stations(scene));
  EXPECT_TRUE(has(check.findings, Severity::kWarning, "texture"));
  EXPECT_FALSE(has(check.findings, Severity::kError, "poses"));
  EXPECT_FALSE(has(check.findings, Severity::kWarning, "poses"));
}

// B10, closed form: every ratio exact but for one in ten, which is wrong by half. Fails without the
// weights, and with the gauge by the logarithms.
TEST(FeatureChecks, GainsOfExactColours) {
  const std::array<std::array<double, 3>, 4> truth{
      {{1.2, 1.0, 0.9}, {0.9, 1.0, 1.1}, {1.0, 1.1, 1.0}, {0.9, 0.9, 1.0}}};  // mean 1 each
  std::mt19937 random(1);
  std::vector<ColourPair> pairs;
  for (int i = 0; i < 600; ++i) {
    ColourPair pair{i % 4, (i + 1 + i % 3) % 4, {}, {}};
    if (pair.a == pair.b) continue;
    for (size_t k = 0; k < 3; ++k) {
      const double colour = 30 + random() % 150;
      pair.colour_a[k] = colour * truth[size_t(pair.a)][k];
      pair.colour_b[k] = colour * truth[size_t(pair.b)][k] * (i % 10 == 0 ? 1.5 : 1);
    }
    pairs.push_back(pair);
  }
  const auto gains = fit_gains({"a", "b", "c", "d"}, pairs);
  for (size_t k = 0; k < 3; ++k) {
    double mean = 0;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_NEAR(gains[c].gain[k] / truth[c][k], 1, 1e-3);
      mean += gains[c].gain[k] / 4;
    }
    EXPECT_NEAR(mean, 1, 1e-15);  // rounding of four terms
  }
}

// B10 on images, held-out camera left out (B18): gains to 1 %, and dividing by them gives the
// images back. Fails with the held-out camera in the fit.
TEST(FeatureChecks, GainsOfImages) {
  const Scene rig = textured_rig();
  Scene scene = rig;
  const std::array<double, 3> up{1.2, 1.0, 0.9}, down{0.8, 1.0, 1.1};
  for (Frame& frame : scene.frames) {
    if (frame.camera_name == "cam0") {
      frame.split = Split::kTest;
      for (uint8_t& value : frame.image.data) value = uint8_t(value / 2);
    }
    const auto* gain = frame.camera_name == "cam4"   ? &up
                       : frame.camera_name == "cam5" ? &down
                                                     : nullptr;
    if (gain == nullptr) continue;
    for (size_t k = 0; k < frame.image.data.size(); ++k)
      frame.image.data[k] =
          uint8_t(std::min(255L, std::lround(frame.image.data[k] * (*gain)[k % 3])));
  }
  const MatchedStations matched = match_stations(scene);
  EXPECT_TRUE(has(check_exposure(matched).findings, Severity::kWarning, "exposure"));
  EXPECT_FALSE(has(check_exposure(match_stations(rig)).findings, Severity::kWarning, "exposure"));
  const std::vector<CameraGain> gains = fit_exposure(matched);
  ASSERT_EQ(gains.size(), 7u);  // cam0 is held out
  for (const CameraGain& camera : gains)
    for (size_t k = 0; k < 3; ++k) {
      const double truth = camera.camera == "cam4" ? up[k] : camera.camera == "cam5" ? down[k] : 1;
      EXPECT_NEAR(camera.gain[k] / truth, 1, 0.01) << camera.camera << " " << k;
    }
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    if (scene.frames[i].camera_name != "cam4") continue;
    Image8 image = scene.frames[i].image;
    apply_exposure(image, up);
    for (size_t p = 0; p < image.data.size(); ++p)
      if (scene.frames[i].image.data[p] < 250) {  // half a level before and half after, /0.9
        ASSERT_NEAR(image.data[p], rig.frames[i].image.data[p], 1) << p;
      }
  }
}

// Bug put back: gains against the mean, which one dark camera drags; seen to fail.
TEST(FeatureChecks, OneDarkCameraAccusesNoOther) {
  Scene scene = textured_rig();
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam3")
      for (uint8_t& value : frame.image.data) value = uint8_t(std::lround(0.6 * value));
  const ExposureCheck check = check_exposure(match_stations(scene));
  std::vector<std::string> named;
  for (const Finding& finding : check.findings)
    if (finding.severity == Severity::kWarning) named.push_back(finding.camera);
  EXPECT_EQ(named, std::vector<std::string>{"cam3"});
  EXPECT_NEAR(check.gains[3].gain[1], 0.6, 0.02);
}

// The lines of a preparation. Bug put back: findings for information are lines, too; seen to fail.
TEST(FeatureChecks, TurnedAndDarkCamerasAreLines) {
  Scene scene = textured_rig();
  std::vector<CameraRow> rows(2);
  rows[0].name = "cam3";
  rows[1].name = "cam4";
  EXPECT_TRUE(camera_warnings(scene, scene, rows).empty());
  turn(scene, "cam4", 90, {0, 0, 1});
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam3")
      for (uint8_t& value : frame.image.data) value = uint8_t(std::lround(0.6 * value));
  Scene all = scene;  // of two timesteps, as cameras of one frame may move
  for (Frame frame : scene.frames) {
    frame.time = 1;
    frame.timestep = 1;
    all.frames.push_back(frame);
  }
  const std::vector<std::string> lines = camera_warnings(all, scene, rows);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_TRUE(lines[0].starts_with("cam4 lies on its side against 7 of 8 cameras")) << lines[0];
  EXPECT_TRUE(lines[1].starts_with("cam3 records 0.")) << lines[1];
  ASSERT_TRUE(rows[0].gain && rows[1].roll);
  EXPECT_NEAR(*rows[0].gain, 0.6, 0.02);
  EXPECT_NEAR(std::abs(*rows[1].roll), 90, 5);
  EXPECT_EQ(rows[0].notes, std::vector<std::string>{"dark"});
  EXPECT_EQ(rows[1].notes, std::vector<std::string>{"turned"});
}

// Cameras that see other things than the rest: cam2 as bright as the rest, cam5 a stop darker. Bug
// put back: cameras without matches only counted; seen to fail.
TEST(FeatureChecks, ExposureWithoutSharedFeatures) {
  Scene scene = textured_rig();
  for (Frame& frame : scene.frames) {
    if (frame.camera_name != "cam2" && frame.camera_name != "cam5") continue;
    const double gain = frame.camera_name == "cam5" ? 0.7 : 1;
    std::vector<uint8_t> other = frame.image.data;  // upside down and mirrored: nothing matches
    std::reverse(other.begin(), other.end());
    for (uint8_t& value : other) value = uint8_t(std::lround(gain * (220 - value)));
    frame.image.data = std::move(other);
  }
  const ExposureCheck check = check_exposure(match_stations(scene));
  std::vector<std::string> named;
  for (const Finding& finding : check.findings)
    if (finding.severity == Severity::kWarning) named.push_back(finding.camera);
  EXPECT_EQ(named, std::vector<std::string>{"cam5"});
  EXPECT_LT(check.gains[5].pairs, 20);
  EXPECT_LT(check.gains[2].pairs, 20);
}

// Fails with the Laplacian at one size alone, which follows contrast: cam2 has half of it.
TEST(FeatureChecks, BlurredCamera) {
  Scene scene = textured_rig();
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam2")
      for (uint8_t& value : frame.image.data) value = uint8_t(64 + value / 2);
  EXPECT_FALSE(has(check_sharpness(scene).findings, Severity::kWarning, "blur"));
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam3") {
      cv::Mat image(frame.image.height, frame.image.width, CV_8UC3, frame.image.data.data());
      cv::GaussianBlur(image, image, {}, 1.5);
    }
  const SharpnessCheck check = check_sharpness(scene);
  ASSERT_TRUE(has(check.findings, Severity::kWarning, "blur"));
  EXPECT_EQ(check.findings.front().camera, "cam3");
}

}  // namespace
}  // namespace tessera::testing
