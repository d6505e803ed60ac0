// Point clouds of the plane sweep: limits, repeatability, removal of duplicates, the images that
// count, and the cloud of a prepared scene. Source: failure modes B12, B18.
#include "ingest/cloud/dense_cloud.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "ingest/clocks/timesteps.h"
#include "ingest/cloud/initial_cloud.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/prepared/prepared_scene.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/parallel.h"
#include "tests/ingest/cloud/equal_clouds.h"
#include "tests/ingest/cloud/wall_scene.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {
namespace {

/// Held-out cameras see another colour: blue is 255 everywhere, elsewhere at most 247.
void hold_out(Scene& scene, const std::set<std::string>& cameras) {
  for (Frame& frame : scene.frames) {
    if (!cameras.contains(frame.camera_name)) continue;
    frame.split = Split::kTest;
    for (size_t i = 2; i < frame.image.data.size(); i += 3) frame.image.data[i] = 255;
  }
}

PointCloud dense_cloud(const Scene& scene, const CloudOptions& options) {
  return cloud_of(dense_points(PlaneSweep(scene), options));
}

int64_t marked(const PointCloud& cloud) {
  return std::count_if(cloud.colour.begin(), cloud.colour.end(),
                       [](const auto& rgb) { return rgb[2] == 255; });
}

// Bug put back: the limit checked once a round; seen to fail.
TEST(DenseCloud, AsManyPointsAsAllowed) {
  const Scene scene = wall_scene();
  for (int64_t limit : {0, 1, 100, 257}) {
    const PointCloud cloud = dense_cloud(scene, {limit, 1, {}});
    EXPECT_EQ(int64_t(cloud.position.size()), limit);
    EXPECT_EQ(int64_t(cloud.colour.size()), limit);
    EXPECT_EQ(int64_t(cloud.time.size()), limit);
    EXPECT_EQ(int64_t(cloud.still.size()), limit);
  }
  EXPECT_TRUE(dense_cloud(wall_scene({.cameras = 2}), {100, 1, {}}).position.empty());
}

TEST(DenseCloud, SameSeedSamePointsOnAnyNumberOfThreads) {
  const Scene scene = wall_scene({.cameras = 4});
  const PointCloud first = dense_cloud(scene, {300, 7, {}});
  set_thread_count(1);
  const PointCloud alone = dense_cloud(scene, {300, 7, {}});
  set_thread_count(3);
  const PointCloud three = dense_cloud(scene, {300, 7, {}});
  set_thread_count(0);
  expect_equal(first, alone);
  expect_equal(first, three);
  EXPECT_NE(dense_cloud(scene, {300, 8, {}}).position[0], first.position[0]);
}

// Bug put back: static points distinguished by their timestep; seen to fail.
TEST(DenseCloud, StillPointsOnceMovingOnesAtTheirTimesteps) {
  // images so small that most pixels are tried several times
  const PointCloud cloud = dense_cloud(wall_scene({.timesteps = 4, .size = 40}), {4000, 1, {}});
  std::set<std::tuple<float, float, float>> places;
  int64_t still = 0, moving = 0;
  std::set<float> timesteps;
  for (size_t i = 0; i < cloud.position.size(); ++i) {
    const glm::vec3& p = cloud.position[i];
    if (cloud.still[i] == 0) {
      ++moving;
      timesteps.insert(cloud.time[i]);
      continue;
    }
    ++still;
    EXPECT_TRUE(places.emplace(p.x, p.y, p.z).second) << "kept twice";
  }
  EXPECT_GT(still, 200);
  EXPECT_GT(moving, 100);
  EXPECT_EQ(timesteps, (std::set<float>{0, float(1 / 3.0), float(2 / 3.0), 1}));
}

// Bug put back: `part` is ignored; seen to fail.
TEST(DenseCloud, OneOfTheParts) {
  const Scene scene = wall_scene({.timesteps = 4});
  for (const CloudPart part : {CloudPart::kStill, CloudPart::kMoving}) {
    CloudOptions options{500, 1, {}};
    options.part = part;
    const PointCloud cloud = dense_cloud(scene, options);
    EXPECT_EQ(cloud.position.size(), 500u) << "enough of either";
    EXPECT_EQ(std::count(cloud.still.begin(), cloud.still.end(), part == CloudPart::kStill ? 1 : 0),
              500);
  }
}

// Bug put back: the sweep takes the frames of all splits; seen to fail.
TEST(DenseCloud, HeldOutCamerasGiveNoPointsAndNoColours) {
  Scene scene = wall_scene({.cameras = 8});
  hold_out(scene, {"cam0", "cam2", "cam4"});
  const PointCloud cloud = dense_cloud(scene, {2000, 1, {}});
  EXPECT_GT(cloud.position.size(), 1000u);
  EXPECT_EQ(marked(cloud), 0);
}

Capture write_scene(const Scene& scene, const std::filesystem::path& folder) {
  Capture prepared;
  prepared.layout = "n3dv";
  prepared.background = "opaque";
  for (const Frame& frame : scene.frames) {
    write_png(folder / (frame.name + ".png"), frame.image);
    CaptureFrame& written = prepared.frames.emplace_back();
    written.file_path = frame.name + ".png";
    written.frame = frame;
    written.frame.image = {};
    if (frame.frame_number == 0) prepared.cameras.push_back({frame.camera_name, {}, 0});
  }
  write_prepared_scene(folder, prepared);
  return prepared;
}

/// The cloud that a prepared scene of `scene` gets.
PointCloud made(const Scene& scene, const IngestOptions& options, PointCloud sparse,
                std::vector<std::string>& warnings) {
  const TemporaryFolder folder;
  Capture capture = write_scene(scene, folder.path());
  capture.points = std::move(sparse);
  add_initial_cloud(
      folder.path(), options, [](std::string_view, int64_t, int64_t) {}, capture);
  warnings = std::move(capture.warnings);
  return std::move(capture.points);
}

// Bugs put back: the thinned load keeps all splits, with the bug of the test above; times of the
// thinned scene normalised again; each seen to fail.
TEST(InitialCloud, FromTrainingImagesOfTimestepsSpreadOverTheClip) {
  Scene scene = wall_scene({.cameras = 7, .timesteps = 20, .size = 48});
  hold_out(scene, {"cam1", "cam3", "cam5"});
  IngestOptions options;
  options.cloud_points = 1500;
  std::vector<std::string> warnings;
  const PointCloud cloud = made(scene, options, {}, warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_GT(cloud.position.size(), 500u);
  EXPECT_LE(cloud.position.size(), 1500u);
  EXPECT_EQ(marked(cloud), 0);
  std::map<float, int64_t> moving;
  std::set<float> still, keys, motion_keys;
  for (size_t i = 0; i < cloud.position.size(); ++i)
    if (cloud.still[i] == 1)
      still.insert(cloud.time[i]);
    else
      ++moving[cloud.time[i]];
  for (const int64_t key : key_timesteps(20, 100)) keys.insert(float(double(key) / 19));
  for (const int64_t motion_key : motion_timesteps(20))
    motion_keys.insert(float(double(motion_key) / 19));
  EXPECT_EQ(still, keys);
  for (const auto& [time, count] : moving) {
    EXPECT_TRUE(motion_keys.contains(time)) << time;
    EXPECT_LE(count, (750 + 10) / 11) << "an equal share of half of the points";
  }
  EXPECT_EQ(moving.size(), motion_keys.size());
}

// Bugs put back, each seen to fail: the timesteps of a loaded part grouped anew, so that no point
// moves; one point a voxel and time, so that nearly twice as many are taken; cameras compared as if
// they saw a timestep at once (0.2 frames apart: 830 points move).
TEST(InitialCloud, WhatMovesIsFoundWhateverTheClocks) {
  IngestOptions options;
  options.cloud_points = 4000;
  std::vector<std::string> warnings;
  std::map<double, int64_t> moving, with_velocity;
  for (const double apart : {0.0, 1e-11, 1e-9, 1e-3, 0.2, 0.45}) {
    const PointCloud cloud =
        made(wall_scene({.cameras = 5, .timesteps = 12, .size = 48, .apart = apart}), options, {},
             warnings);
    for (size_t i = 0; i < cloud.position.size(); ++i) {
      moving[apart] += cloud.still[i] == 0;
      with_velocity[apart] += cloud.velocity[i] != glm::vec3(0);
    }
    // 0.45 frames apart the pattern moves by most of its wave between the cameras
    const double least = apart < 0.4 ? 0.9 : 0.75;
    EXPECT_GT(double(moving[apart]), least * double(moving[0])) << apart;
    EXPECT_GT(double(with_velocity[apart]), least * double(with_velocity[0])) << apart;
  }
  EXPECT_GT(moving[0], 500);
  EXPECT_GT(with_velocity[0], 200);
  EXPECT_TRUE(warnings.empty());
}

// Bug put back: frames for validation left out; seen to fail.
TEST(InitialCloud, OfFramesInMemoryThatOfTheirFolder) {
  Scene scene = wall_scene({.cameras = 7, .timesteps = 12, .size = 48});
  hold_out(scene, {"cam1", "cam3"});
  const TemporaryFolder folder;
  write_scene(scene, folder.path());
  Scene loaded = load_scene(folder.path(), {});
  for (Frame& frame : loaded.frames)
    if (frame.split == Split::kTrain && frame.frame_number % 3 == 1)
      frame.split = Split::kValidation;
  CloudOptions options;
  options.points = 1500;
  const RigCloud read = rig_cloud(FolderFrames(folder.path()), options),
                 held = rig_cloud(SceneFrames(loaded), options);
  expect_equal(held.points, read.points);
  EXPECT_GT(read.velocities.reliable, 100);
  EXPECT_EQ(marked(held.points), 0);
}

/// Notes which timesteps are asked for, one after the other.
class NotedFrames : public CloudFrames {
 public:
  explicit NotedFrames(const Scene& scene) : frames_(scene) {}
  const Scene& listed() const override { return frames_.listed(); }
  Scene at(const std::vector<int64_t>& timesteps) const override {
    asked.push_back(timesteps);
    return frames_.at(timesteps);
  }
  mutable std::vector<std::vector<int64_t>> asked;

 private:
  SceneFrames frames_;
};

// Bug put back: timesteps leave the window as soon as the next one is looked at; seen to fail.
TEST(InitialCloud, AsksForATimestepOnce) {
  const Scene scene = wall_scene({.timesteps = 13, .size = 32});
  const NotedFrames frames(scene);
  CloudOptions options;
  options.points = 200;
  rig_cloud(frames, options);
  ASSERT_FALSE(frames.asked.empty());
  EXPECT_EQ(frames.asked[0], key_timesteps(13, 100)) << "at once, as all of them are compared";
  std::vector<std::vector<int64_t>> each;
  for (int64_t timestep = 0; timestep < 13; ++timestep) each.push_back({timestep});
  EXPECT_EQ(std::vector(frames.asked.begin() + 1, frames.asked.end()), each);
}

// Bug put back: a rig on which nothing changes warned of; seen to fail.
TEST(InitialCloud, WarnsOfChangesInWhichNothingMoves) {
  RigCloud cloud;
  cloud.points.position.resize(10);
  cloud.changing_share = 0.2;
  EXPECT_NE(motion_warning(cloud).find("20 % of the pixels change over time"), std::string::npos);
  cloud.velocities.moving = 3;
  EXPECT_EQ(motion_warning(cloud), "");
  cloud.velocities.moving = 0;
  cloud.changing_share = 0.001;
  EXPECT_EQ(motion_warning(cloud), "");
}

// Bug put back: a stated density is ignored; seen to fail.
TEST(InitialCloud, DensityIsAChoice) {
  const Scene scene = wall_scene({.size = 48});
  const PointCloud sparse{{{1, 2, 3}}, {{{9, 8, 7}}}, {}, {}, {}};
  std::vector<std::string> warnings;
  IngestOptions options;
  options.cloud_points = 50;
  const PointCloud usual = made(scene, options, sparse, warnings);
  ASSERT_EQ(usual.position.size(), 51u) << "added to the sparse points";
  EXPECT_TRUE(std::isnan(usual.time[0]));
  EXPECT_EQ(usual.still[0], PointCloud::kStillUnknown);
  options.cloud = CloudDensity::kSparse;
  expect_equal(made(scene, options, sparse, warnings), sparse);
  options.cloud = CloudDensity::kNone;
  EXPECT_TRUE(made(scene, options, sparse, warnings).position.empty());
  EXPECT_TRUE(warnings.empty());
}

TEST(InitialCloud, NoRigNoDenseCloud) {
  const Scene pair = wall_scene({.cameras = 2, .size = 48});
  std::vector<std::string> warnings;
  IngestOptions options;
  EXPECT_TRUE(made(pair, options, {}, warnings).position.empty());
  EXPECT_TRUE(warnings.empty());
  options.cloud = CloudDensity::kDense;
  EXPECT_TRUE(made(pair, options, {}, warnings).position.empty());
  ASSERT_EQ(warnings.size(), 1u) << "it was asked for";
  EXPECT_NE(warnings[0].find("no three training cameras"), std::string::npos);
}

// Photos of one timestep have the points of their COLMAP model, also where the layout states none
// and the model is estimated. Bug put back: the layout is compared by its name with "colmap"; seen
// to fail.
TEST(InitialCloud, NoPlaneSweepOverPhotosByItself) {
  const Scene scene = wall_scene({.cameras = 5, .size = 48});
  for (const char* layout : {"colmap", "photos"}) {
    const TemporaryFolder folder;
    Capture capture = write_scene(scene, folder.path());
    capture.layout = layout;
    capture.photos = folder.path();
    bool swept = false;
    add_initial_cloud(
        folder.path(), {}, [&](std::string_view, int64_t, int64_t) { swept = true; }, capture);
    EXPECT_FALSE(swept) << layout;
    EXPECT_TRUE(capture.points.position.empty()) << layout;
    EXPECT_FALSE(cameras_of_a_rig(capture)) << layout;
  }
}

// Bug put back: held-out cameras counted; seen to fail.
TEST(InitialCloud, CamerasOfARigAreCounted) {
  for (int cameras : {1, 2, 4, 5, 7}) {
    const TemporaryFolder folder;
    Scene scene = wall_scene({.cameras = cameras + 1, .size = 8});
    hold_out(scene, {"cam0"});
    Capture capture = write_scene(scene, folder.path());
    EXPECT_EQ(cameras_of_a_rig(capture), cameras);
  }
}

}  // namespace
}  // namespace tessera::testing
