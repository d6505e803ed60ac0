// The loaders on third-party captures, against known facts about them. Tests whose data is absent
// are skipped with a message.
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/ingest.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/prepared/scene_reader.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

SceneOptions without_pixels() {
  SceneOptions options;
  options.load_pixels = false;
  return options;
}

TEST(RealData, DnerfLego) {
  TESSERA_NEED_DATA(folder, "dnerf_lego");
  const Scene scene = load_scene(folder, without_pixels());
  EXPECT_EQ(scene.split_indices(Split::kTrain).size(), 50u);
  EXPECT_EQ(scene.split_indices(Split::kVal).size(), 11u);
  EXPECT_EQ(scene.split_indices(Split::kTest).size(), 20u);
  EXPECT_FALSE(scene.is_static);
  EXPECT_TRUE(scene.had_alpha);
  const Frame& frame = scene.frames[1];
  EXPECT_EQ(frame.name, "train/r_1");
  EXPECT_NEAR(frame.time, 2.0 / 99, 1e-9);
  EXPECT_EQ(frame.camera.width, 800);
  EXPECT_NEAR(frame.camera.fl_x, 400 / std::tan(0.5 * 0.6911112070083618), 1e-9);
  for (const Frame& each : scene.frames) {  // all cameras look at the object near the origin
    const glm::dvec2 centre = project(each.camera, {0, 0, 0.3});
    EXPECT_GT((each.camera.cam_from_world * glm::dvec3(0) + each.camera.translation).z, 0);
    EXPECT_LT(glm::distance(centre, glm::dvec2(400)), 300) << each.name;
  }
}

TEST(RealData, DnerfLegoPixels) {
  TESSERA_NEED_DATA(folder, "dnerf_lego");
  SceneOptions options;
  options.background = {255, 255, 255};
  const Scene scene = load_scene(folder, options);
  for (const Frame& frame : scene.frames) {
    ASSERT_EQ(frame.image.data.size(), 800u * 800u * 3u);
    EXPECT_EQ(frame.image.data[0], 255) << frame.name;  // corners are empty
  }
}

TEST(RealData, StressFocalLengthsOfFramesWin) {
  for (const char* name : {"occlusion", "rapid_motion", "deformation", "topology"}) {
    TESSERA_NEED_DATA(folder, std::string("stress/") + name);
    const Scene scene = load_scene(folder, without_pixels());
    std::set<double> focal_lengths;
    for (const Frame& frame : scene.frames) focal_lengths.insert(frame.camera.fl_x);
    EXPECT_EQ(focal_lengths.size(), 3u) << name;
    EXPECT_EQ(scene.time_axis.duration, 1.0) << name;
    EXPECT_EQ(scene.points.position.size(), name == std::string("deformation") ? 100000u : 0u);
  }
}

TEST(RealData, NerfSyntheticIsStatic) {
  TESSERA_NEED_DATA(folder, "mic");
  const Scene scene = load_scene(folder, without_pixels());
  EXPECT_TRUE(scene.is_static);
  EXPECT_EQ(scene.frames.size(), 150u);
}

TEST(RealData, DistortedCaptureIsRefused) {
  TESSERA_NEED_DATA(folder, "colmap_room");
  expect_input_error([&] { load_scene(folder, without_pixels()); }, {"k1", "undistort"});
}

Camera studio_camera(const json& truth, size_t index) {
  PoseRows rows{};
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) rows[r][c] = truth["cameras"][index]["transform_matrix"][r][c];
  Camera camera{truth["w"], truth["h"], truth["fl_x"], truth["fl_y"], truth["cx"], truth["cy"],
                {},         {}};
  set_pose(camera, rows, "studio");
  return camera;
}

TEST(RealData, StudioPosesAreTheTrueOnes) {
  TESSERA_NEED_DATA(folder, "studio");
  const json truth = json::parse(read_bytes(folder / "ground_truth.json"));
  const auto poses = read_llff_poses(folder / "poses_bounds.npy");
  ASSERT_EQ(poses.size(), 11u);
  for (size_t i = 0; i < poses.size(); ++i)
    expect_same_camera(studio_camera(truth, i), poses[i].camera, 1e-6);
}

TEST(RealData, StudioPreparedScene) {
  TESSERA_NEED_DATA(folder, "studio");
  const TemporaryFolder out;
  IngestOptions options;
  options.scale = 0.25;
  options.cloud = CloudDensity::kNone;  // dense_cloud_test.cpp has clouds
  IngestReport report;
  try {
    report = ingest_capture(folder, out / "scene", options, {});
  } catch (const InputError& error) {
    if (std::string(error.what()).find("trainer-only") != std::string::npos)
      GTEST_SKIP() << "trainer-only build";
    throw;
  }
  EXPECT_EQ(report.cameras, 11);
  EXPECT_EQ(report.frames, 36 * 11);
  const Scene scene = load_scene(out / "scene", {});
  EXPECT_EQ(scene.split_indices(Split::kTest).size(), 36u);
  EXPECT_EQ(scene.frames[size_t(scene.split_indices(Split::kTest)[0])].camera_name, "cam00");
  EXPECT_NEAR(scene.time_axis.duration, 35.0 / 24, 1e-9);
  EXPECT_NEAR(scene.frames[7].time, 7.0 / 35, 1e-9);
  EXPECT_EQ(scene.frames[7].image.width, 120);
  const json truth = json::parse(read_bytes(folder / "ground_truth.json"));
  // The world is normalised; undone, the poses are those of the truth.
  EXPECT_GT(scene.prepared_from_source.scale, 0);
  EXPECT_FALSE(scene.prepared_from_source.is_identity());
  expect_same_camera(camera_in_world(inverse(scene.prepared_from_source), scene.frames[36].camera),
                     studio_camera(truth, 1).resized(120, 90), 1e-6);
}

/// Poses of the model's images by name, of COLMAP's binary format.
std::map<std::string, Camera> colmap_poses(const std::filesystem::path& images_bin) {
  const std::string bytes = read_bytes(images_bin);
  size_t position = 0;
  const auto take = [&](auto value) {
    std::memcpy(&value, bytes.data() + position, sizeof value);
    position += sizeof value;
    return value;
  };
  std::map<std::string, Camera> poses;
  for (uint64_t left = take(uint64_t{}); left > 0; --left) {
    take(uint32_t{});
    double q[4];
    Camera camera;
    for (double& value : q) value = take(0.0);
    for (int i = 0; i < 3; ++i) camera.translation[i] = take(0.0);
    camera.cam_from_world = glm::mat3_cast(glm::dquat(q[0], q[1], q[2], q[3]));
    take(uint32_t{});
    const std::string name = bytes.c_str() + position;
    position += name.size() + 1;
    position += take(uint64_t{}) * 24;
    poses[name] = camera;
  }
  return poses;
}

TEST(RealData, N3dvPosesAgreeWithTheirColmapModel) {
  TESSERA_NEED_DATA(folder, "n3dv_one_instant");
  const auto poses = read_llff_poses(folder / "poses_bounds.npy");
  ASSERT_EQ(poses.size(), 5u);
  EXPECT_EQ(poses[0].camera.width, 2704);
  EXPECT_EQ(poses[0].camera.height, 2028);
  EXPECT_NEAR(poses[0].camera.fl_x, 1462.0671309137679, 1e-9);
  // File i is row i − 1; the model was made of the files under other names.
  const auto model = colmap_poses(folder / "sparse/0/images.bin");
  const std::array<const char*, 5> names{"0.jpg", "3.jpg", "5.jpg", "8.jpg", "14.jpg"};
  const auto from_first = [](const Camera& camera, const Camera& first) {
    return camera.cam_from_world * glm::transpose(first.cam_from_world);
  };
  for (size_t i = 1; i < 5; ++i) {  // the worlds differ by a similarity: compare turns to the first
    const glm::dmat3 one = from_first(poses[i].camera, poses[0].camera);
    const glm::dmat3 other = from_first(model.at(names[i]), model.at(names[0]));
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::distance(one[c], other[c]), 3e-3) << names[i];
  }
}

TEST(RealData, FernPosesAgreeWithTheirColmapModel) {
  TESSERA_NEED_DATA(folder, "fern");
  const auto poses = read_llff_poses(folder / "poses_bounds.npy");
  const auto model = colmap_poses(folder / "sparse_rebuilt/0/images.bin");
  ASSERT_EQ(poses.size(), 20u);
  ASSERT_EQ(model.size(), 20u);
  size_t i = 0;
  for (const auto& [name, stored] : model) {
    // This rebuilt model holds the inverse rotations beside the usual translations (its cameras
    // would look apart, not at the fern); the poses of LLFF are what the image shows.
    Camera camera = stored;
    camera.cam_from_world = glm::transpose(stored.cam_from_world);
    EXPECT_LT(glm::distance(camera.position(), poses[i].camera.position()), 1e-3) << name;
    for (int c = 0; c < 3; ++c)
      EXPECT_LT(glm::distance(camera.cam_from_world[c], poses[i].camera.cam_from_world[c]), 1e-3);
    ++i;
  }
}

}  // namespace
}  // namespace tessera
