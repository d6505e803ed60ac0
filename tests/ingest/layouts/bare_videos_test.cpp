// Rigs as bare videos: poses by `colmap` against their ground truth. The test is slow.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/child_process.h"
#include "ingest/poses/pose_matrix.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/layouts/rendered_rig.h"
#include "tests/support/rig_alignment.h"
#include "tools/synth/synth.h"

namespace tessera::testing {
namespace {

/// Estimates the poses of the videos beside a ground_truth.json, the first camera held out. The
/// product's bound: all cameras, 0.1 degrees, 0.5 % of the rig's extent. COLMAP's matches are drawn
/// at random, so figures differ from run to run. Aligned by the centres alone, which lie nearly in
/// a plane, the turn is uncertain by as much again; that is recorded beside.
void expect_true_poses(const std::filesystem::path& capture) {
  const TemporaryFolder folder;
  std::vector<RigClip> clips;
  std::vector<Camera> truth, estimated;
  nlohmann::json stated;
  std::ifstream(capture / "ground_truth.json") >> stated;
  for (const auto& entry : stated["cameras"]) {
    PoseRows rows;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) rows[r][c] = entry["transform_matrix"][r][c];
    set_pose(truth.emplace_back(), rows, "truth");
    clips.push_back(clip_of(capture / (entry["name"].get<std::string>() + ".mp4")));
  }
  std::vector<char> held_out(clips.size(), 0);
  held_out[0] = 1;
  const auto estimate =
      estimate_rig(clips, held_out, folder / "work", {}, [](std::string_view, int64_t, int64_t) {});
  for (const auto& camera : estimate.cameras) {
    ASSERT_TRUE(camera.has_value());
    estimated.push_back(camera->camera);
  }
  const RigError error = rig_error(estimated, truth);
  const RigError by_centres = rig_error(estimated, truth, AlignBy::kCentres);
  const auto record = [](const char* name, double value) {
    ::testing::Test::RecordProperty(name, std::to_string(value));
  };
  record("rotation_degrees", error.rotation);
  record("centre_percent", 100 * error.centre);
  record("rotation_degrees_by_centres", by_centres.rotation);
  record("centre_percent_by_centres", 100 * by_centres.centre);
  record("focal", estimated[0].fl_x);
  EXPECT_LE(error.rotation, 0.1);
  EXPECT_LE(error.centre, 0.005);
  EXPECT_TRUE(estimate.warnings.empty());
}

TEST(BareVideos, OfTheStudioGiveItsPoses) {
  if (find_program("colmap").empty()) GTEST_SKIP() << "no colmap in PATH";
  TESSERA_NEED_DATA(studio, "studio");
  expect_true_poses(studio);
}

TEST(BareVideos, OfSixteenSyntheticCamerasGiveTheirPoses) {
  if (find_program("colmap").empty()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  SynthOptions options;
  options.layout = SynthLayout::kVideos;
  options.cameras = 16;
  options.frames = 10;
  options.width = 400;
  options.height = 300;
  options.points = 0;
  make_capture(options, folder / "rig", {});
  expect_true_poses(folder / "rig");
}

}  // namespace
}  // namespace tessera::testing
