// Poses of a rig from bare videos against the truth, with the program `colmap` itself. Its failures
// are tested in colmap_program_test.cpp.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/colmap_workspace.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/child_process.h"
#include "ingest/files/png.h"
#include "ingest/ingest.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/prepared/scene_reader.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/layouts/rendered_rig.h"
#include "tests/ingest/video/test_video.h"
#include "tests/support/rig_alignment.h"

namespace tessera::testing {
namespace {

const IngestProgress kNoProgress = [](std::string_view, int64_t, int64_t) {};

bool has_colmap() {
  return !find_program("colmap").empty();
}

std::vector<Camera> cameras_of(const PoseEstimate& estimate) {
  std::vector<Camera> cameras;
  for (const auto& camera : estimate.cameras)
    if (camera) cameras.push_back(camera->camera);
  return cameras;
}

/// How many points have the colour that only the held-out camera sees.
int blue_points(const PoseEstimate& estimate) {
  int count = 0;
  for (const auto& colour : estimate.points.colour) count += colour[2] > 165;
  return count;
}

// Closed form: a world that was turned, scaled and moved comes back with no error, and one camera
// that is turned by 0.3 degrees on the spot shows as that. Catches: alignment the wrong way round,
// a transposed rotation, a mean left out.
TEST(RigAlignment, UndoesASimilarityAndMeasuresWhatIsLeft) {
  const auto truth = true_cameras({});
  const Similarity world{
      2.5,
      glm::dmat3(glm::rotate(glm::dmat4(1), 1.1, glm::normalize(glm::dvec3(1, -2, 0.5)))),
      {3, -4, 5}};
  std::vector<Camera> moved = truth;
  for (Camera& camera : moved) {
    const glm::dvec3 centre = world(camera.position());
    camera.cam_from_world = camera.cam_from_world * glm::transpose(world.rotation);
    camera.translation = -(camera.cam_from_world * centre);
  }
  RigError error = rig_error(moved, truth, AlignBy::kCentres);
  EXPECT_LT(error.rotation, 1e-10);
  EXPECT_LT(error.centre, 1e-12);
  EXPECT_NEAR(error.alignment.scale, 1 / 2.5, 1e-12);
  const double angle = 0.3 * M_PI / 180;
  const glm::dvec3 centre = moved[3].position();
  moved[3].cam_from_world =
      glm::dmat3(glm::rotate(glm::dmat4(1), angle, glm::dvec3(0, 1, 0))) * moved[3].cam_from_world;
  moved[3].translation = -(moved[3].cam_from_world * centre);
  error = rig_error(moved, truth, AlignBy::kCentres);
  EXPECT_NEAR(error.rotation, 0.3, 1e-9);
  EXPECT_EQ(error.worst_rotation, 3u);
}

// Failure mode B5, and the product's bound: rotation 0.1 degrees, centres 0.5 % of the extent. The
// panel fills a third of the images, and the cameras' clocks differ, so each sees it elsewhere.
// The folder's name has what a shell would trip over. Catches: no
// mask (seen without: 0.31 degrees with medians, 23.7 on first frames), points of all cameras
// (B18), a shell.
TEST(RigPoses, MovingTextureIsMaskedAndAllCamerasComeOutRight) {
  if (!has_colmap()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  const auto videos = folder / "it's \"ü\" & $HOME; --x";
  std::filesystem::create_directories(videos);
  const RenderedRig rig{.frames = 7, .panel_step = 0.31, .blue_camera = 0};
  auto clips = write_rig(videos, rig);
  TestVideo blank;  // failure mode B2: a camera that sees nothing
  blank.frames.assign(7, {320, 240, 3, std::vector<uint8_t>(size_t(320 * 240 * 3), 90)});
  write_video(videos / "blank.mp4", blank);
  clips.push_back(clip_of(videos / "blank.mp4"));
  std::vector<char> held_out(clips.size(), 0);
  const auto all = estimate_rig(clips, held_out, videos / "-work", {}, kNoProgress);
  held_out[0] = 1;
  const auto estimate = estimate_rig(clips, held_out, videos / "-work", {}, kNoProgress);
  EXPECT_GT(blue_points(all), 30);  // seen: 79 and 7, what coding does to colour at edges
  EXPECT_LT(5 * blue_points(estimate), blue_points(all));
  ASSERT_EQ(cameras_of(estimate).size(), size_t(rig.cameras));
  EXPECT_FALSE(estimate.cameras.back().has_value());
  ASSERT_EQ(estimate.warnings.size(), 1u);
  EXPECT_NE(estimate.warnings[0].find("registered 8 of 9 cameras, not blank"), std::string::npos)
      << estimate.warnings[0];
  PoseOptions strict;
  strict.strict = true;
  EXPECT_THROW(estimate_rig(clips, held_out, videos / "-work", strict, kNoProgress), InputError);
  const RigError error = rig_error(cameras_of(estimate), true_cameras(rig));
  RecordProperty("rotation", std::to_string(error.rotation));
  RecordProperty("centre", std::to_string(error.centre));
  EXPECT_LE(error.rotation, 0.1);
  EXPECT_LE(error.centre, 0.005);
  EXPECT_GT(estimate.points.position.size(), 300u);
}

// Anamorphic video, 4:3 pixels. Bug put back: one focal length, which fits it by distortion; seen
// to fail.
TEST(RigPoses, PixelsThatAreNotSquareGetTwoFocalLengths) {
  if (!has_colmap()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  const RenderedRig rig{.cameras = 5, .width = 240, .pixel_aspect = 4.0 / 3};
  const auto clips = write_rig(folder.path(), rig);
  ASSERT_NEAR(clips.front().timeline.pixel_aspect, 4.0 / 3, 1e-9);
  const auto estimate = estimate_rig(clips, {}, folder / "work", {}, kNoProgress);
  ASSERT_EQ(cameras_of(estimate).size(), size_t(rig.cameras));
  for (const Camera& camera : cameras_of(estimate))
    EXPECT_NEAR(camera.fl_y / camera.fl_x, 4.0 / 3, 0.02);
  const RigError error = rig_error(cameras_of(estimate), true_cameras(rig));
  EXPECT_LE(error.rotation, 0.2);
  EXPECT_LE(error.centre, 0.01);
}

// As `run` after `doctor`. Bugs put back, each seen to fail: no look into the cache; a result of
// the cache taken for a workspace with images (other held-out cameras have no points then).
TEST(RigPoses, AreKeptForAnotherOutput) {
  if (!has_colmap()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  const auto clips = write_rig(folder.path(), {.cameras = 4});
  std::vector<char> held_out{1, 0, 0, 0};
  PoseOptions options;
  options.cache = folder / "cache";
  const auto estimate = [&](const char* work) {
    return estimate_rig(clips, held_out, folder / work, options, kNoProgress);
  };
  const PoseEstimate first = estimate("one"), second = estimate("two");
  EXPECT_FALSE(first.reused);
  EXPECT_TRUE(second.reused);
  EXPECT_EQ(read_bytes(folder / "two/colmap.log").find("mapper"), std::string::npos);
  EXPECT_EQ(second.points.position, first.points.position);
  EXPECT_EQ(cameras_of(second).size(), cameras_of(first).size());
  held_out = {0, 1, 0, 0};
  EXPECT_GT(estimate("two").points.position.size(), 100u);
}

// Known poses. Points lie on the room's true surfaces to 0.08 units (z² / (f b) = 4.5² / (288 ·
// 0.9): a pixel's depth between neighbours). Still ones have the first timestep; the panel's their
// own. The clocks of this rig agree. Catches: poses or times mixed up between cameras.
TEST(KnownPosePoints, StillAndMovingPointsLieOnTheirSurfaces) {
  if (!has_colmap()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  const RenderedRig rig{.cameras = 5, .frames = 7, .panel_step = 0.31, .clocks_agree = true};
  auto clips = write_rig(folder.path(), rig);
  const auto truth = true_cameras(rig);
  for (size_t i = 0; i < clips.size(); ++i)
    clips[i].camera = RigCamera{clips[i].name, truth[i], {}, "PINHOLE"};
  const std::vector<RigInstant> instants{{0.25, std::vector<std::optional<size_t>>(5, 1)},
                                         {1.0, std::vector<std::optional<size_t>>(5, 6)}};
  const PointCloud points = triangulate_instants(clips, std::vector<char>(5, 0), instants,
                                                 folder / "work", {}, kNoProgress);
  ASSERT_EQ(points.time.size(), points.position.size());
  ASSERT_EQ(points.still.size(), points.position.size());
  int still = 0, off = 0, moving[2] = {0, 0}, off_panel = 0;
  for (size_t i = 0; i < points.position.size(); ++i) {
    const bool is_off = distance_to_surface(points.position[i]) > 0.08;
    if (points.still[i]) {
      ++still;
      off += is_off;
      EXPECT_EQ(points.time[i], 0.25f);
    } else {
      ++moving[points.time[i] == 1.0f];
      off_panel += is_off;
    }
  }
  RecordProperty("still", still);
  RecordProperty("moving", moving[0] + moving[1]);
  EXPECT_GT(still, 200);
  EXPECT_GT(moving[0], 50);
  EXPECT_GT(moving[1], 50);
  EXPECT_LE(off, still / 20);  // matches that are wrong and fit by chance
  EXPECT_LE(off_panel, (moving[0] + moving[1]) / 20);
}

// A folder of photos without a model. Catches: single cameras, a model that is not found.
TEST(MovingCamera, PhotosWithoutAModelGetOne) {
  if (!has_colmap()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  const RenderedRig rig{.cameras = 6};
  for (int i = 0; i < rig.cameras; ++i)
    write_png(folder / "my photos" / ("p " + std::to_string(i) + ".png"),
              rendered_image(rig, i, 0));
  const auto found =
      estimate_moving_camera(folder / "my photos", false, folder / "work", {}, kNoProgress);
  EXPECT_TRUE(found.warnings.empty());
  const ColmapModel model = read_colmap_model(found.folder);
  ASSERT_EQ(model.photos.size(), 6u);
  std::vector<Camera> cameras;
  for (const ColmapPhoto& photo : model.photos) cameras.push_back(photo.camera);
  const RigError error = rig_error(cameras, true_cameras(rig));
  EXPECT_LE(error.rotation, 0.3);  // the mapper's own accuracy, without exact rounds
  EXPECT_LE(error.centre, 0.01);
}

// Numbered images as a rig's, and as those of one camera that moves. Bug put back: the latter read
// as photos, which stand still; seen to fail. COLMAP need not place all of so few cameras.
TEST(ImageSequencesPosed, RigAndMovingCamera) {
  if (!has_colmap()) GTEST_SKIP() << "no colmap in PATH";
  const TemporaryFolder folder;
  const RenderedRig rig{.cameras = 6, .frames = 2, .clocks_agree = true};
  for (int i = 0; i < rig.cameras; ++i) {
    for (int n = 0; n < rig.frames; ++n) {
      const auto camera = folder / "rig" / ("cam" + std::to_string(i));
      std::filesystem::create_directories(camera);
      write_png(camera / ("00" + std::to_string(n) + ".png"), rendered_image(rig, i, n));
    }
    std::filesystem::create_directories(folder / "moving");
    write_png(folder / "moving" / ("frame_0" + std::to_string(2 * i) + ".png"),
              rendered_image(rig, i, 0));
  }
  IngestOptions options;
  options.cloud = CloudDensity::kSparse;
  const IngestReport report =
      ingest_capture(folder / "rig", folder / "scene", options, kNoProgress);
  EXPECT_EQ(report.layout, CaptureLayout::kSequences);
  EXPECT_GE(report.cameras, 3);
  EXPECT_FALSE(load_scene(folder / "scene", {}).is_static);
  options.image_layout = ImageLayout::kMoving;
  options.fps = 10;
  const IngestReport moving =
      ingest_capture(folder / "moving", folder / "walk", options, kNoProgress);
  EXPECT_EQ(moving.layout, CaptureLayout::kSequences);
  EXPECT_TRUE(moving.scored.starts_with("will be scored: 1 test view (1 of the ")) << moving.scored;
  const Scene scene = load_scene(folder / "walk", {});
  EXPECT_FALSE(scene.is_static);
  ASSERT_GE(scene.frames.size(), 3u);
  for (const Frame& frame : scene.frames) {  // numbers 0, 2, 4 … at 10 a second
    const double steps = frame.time * scene.time_axis.duration / 0.2;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
  }
}

}  // namespace
}  // namespace tessera::testing
