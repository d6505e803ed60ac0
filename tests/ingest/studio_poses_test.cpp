// What: the studio scene as bare videos: poses against its ground truth, with `colmap`. Slow.
// Not: training on them.
#include <gtest/gtest.h>

#include <fstream>

#include "ingest/child_process.h"
#include "ingest/media/pose_estimation.h"
#include "ingest/pose_matrix.h"
#include "tests/ingest/capture_fixture.h"
#include "tests/ingest/rendered_rig.h"
#include "tests/support/rig_alignment.h"

namespace tessera::testing {
namespace {

// The product's bound for a real-looking rig: all 11 cameras, 0.1 degrees, 0.5 % of the extent.
// COLMAP's matches are drawn at random: figures differ from run to run. Aligned by the centres
// alone, which lie nearly in a plane, the turn is uncertain by as much again; it is recorded.
TEST(StudioPoses, BareVideosGiveThePoses) {
  if (find_program("colmap").empty()) GTEST_SKIP() << "no colmap in PATH";
  TESSERA_NEED_DATA(studio, "studio");
  const TemporaryFolder folder;
  std::vector<RigClip> clips;
  std::vector<Camera> truth, estimated;
  nlohmann::json stated;
  std::ifstream(studio / "ground_truth.json") >> stated;
  for (const auto& entry : stated["cameras"]) {
    PoseRows rows;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) rows[r][c] = entry["transform_matrix"][r][c];
    set_pose(truth.emplace_back(), rows, "truth");
    clips.push_back(clip_of(studio / (entry["name"].get<std::string>() + ".mp4")));
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
  RecordProperty("rotation_degrees", std::to_string(error.rotation));
  RecordProperty("centre_percent", std::to_string(100 * error.centre));
  const RigError by_centres = rig_error(estimated, truth, AlignBy::kCentres);
  RecordProperty("rotation_degrees_by_centres", std::to_string(by_centres.rotation));
  RecordProperty("centre_percent_by_centres", std::to_string(100 * by_centres.centre));
  RecordProperty("focal", std::to_string(estimated[0].fl_x));
  RecordProperty("points", int(estimate.points.position.size()));
  EXPECT_LE(error.rotation, 0.1);
  EXPECT_LE(error.centre, 0.005);
  EXPECT_TRUE(estimate.warnings.empty());
}

}  // namespace
}  // namespace tessera::testing
