// N3DV captures of small videos are converted to a prepared scene and loaded as a Scene; invalid
// captures are refused.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/ingest.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/prepared/scene_reader.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

class N3dv : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
    std::filesystem::create_directories(folder_ / "capture");
    for (int c = 0; c < 3; ++c) write_video(video(c), numbered_video(5, c));
    write_poses(3);
  }
  std::filesystem::path video(int camera) {
    return folder_ / fmt::format("capture/cam{:02}.mp4", camera);
  }
  /// Poses for images of 64×48, twice the size of the videos, with a focal length of 100.
  void write_poses(int rows) {
    poses_.clear();
    for (int i = 0; i < rows; ++i) {
      const json matrix = gl_matrix(looking_at_origin({4.0, 0.5 * i, 1.0}));
      PoseRows pose{};
      for (size_t r = 0; r < 3; ++r)
        for (size_t c = 0; c < 4; ++c) pose[r][c] = matrix[r][c];
      Camera camera{64, 48, 100, 100, 32, 24, {}, {}};
      set_pose(camera, pose, "test");
      poses_.push_back({camera, 1, 9});
    }
    write_llff_poses(folder_ / "capture/poses_bounds.npy", poses_);
  }
  /// In the world of the poses; the normalised one has a test of its own.
  IngestReport ingest(IngestOptions options = {}) {
    options.keep_world = true;
    return ingest_capture(folder_ / "capture", folder_ / "scene", options, {});
  }

  TemporaryFolder folder_;
  std::vector<LlffPose> poses_;
};

// Bug put back: the focal length of poses_bounds.npy taken for the video's size; seen to fail.
TEST_F(N3dv, FramesCamerasTimesAndSplits) {
  EXPECT_EQ(ingest().layout, CaptureLayout::kN3dv);
  const json file = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(file["tessera"]["source_hashes_fnv1a64"].size(), 4u);
  const Scene scene = load_scene(folder_ / "scene", {});
  ASSERT_EQ(scene.frames.size(), 15u);
  EXPECT_NEAR(scene.time_axis.duration, 4.0 / 25, 1e-9);
  for (size_t i = 0; i < 15; ++i) {
    const Frame& frame = scene.frames[i];
    const int c = int(i / 5), n = int(i % 5);
    EXPECT_EQ(frame.camera_name, fmt::format("cam{:02}", c));
    EXPECT_EQ(frame.name, fmt::format("cam{:02}/{:05}", c, n));
    EXPECT_EQ(frame.frame_number, n);
    EXPECT_NEAR(frame.time, n / 4.0, 1e-9);
    EXPECT_EQ(frame.split, c == 0 ? Split::kTest : Split::kTrain);
    EXPECT_NEAR(frame.image.data[200], numbered_grey(n, c), 1);
    expect_same_camera(frame.camera, poses_[size_t(c)].camera.resized(32, 24), 1e-12);
    EXPECT_EQ(frame.camera.fl_x, 50);
  }
}

// Bug put back: the points left in the source's world; seen to fail.
TEST_F(N3dv, TheWorldIsNormalisedAndRecorded) {
  PointCloud points;
  points.position = {{0, 0, 0}, {0.5f, 0.25f, -1}};
  points.colour = {{1, 2, 3}, {4, 5, 6}};
  write_points(folder_ / "capture/points.ply", points);
  ingest_capture(folder_ / "capture", folder_ / "scene", {}, {});
  const Scene scene = load_scene(folder_ / "scene", {});
  const Similarity world = scene.prepared_from_source;
  // The two training cameras look at the origin from (4, ½, 1) and (4, 1, 1).
  EXPECT_NEAR(world.scale * (std::sqrt(17.25) + std::sqrt(18.0)) / 2, 4, 0.06);
  EXPECT_LT(glm::length(world.translation), 1e-6);
  for (const Frame& frame : scene.frames) {
    const size_t c = size_t(frame.camera_name.back() - '0');
    const Camera expected = camera_in_world(world, poses_[c].camera.resized(32, 24));
    expect_same_camera(frame.camera, expected, 1e-12);
  }
  ASSERT_EQ(scene.points.position.size(), 2u);
  EXPECT_LT(glm::distance(glm::dvec3(scene.points.position[1]), world({0.5, 0.25, -1})), 1e-6);
  // A prepared scene that is prepared again stays in its place and gives the same messages.
  ingest_capture(folder_ / "scene", folder_ / "again", {}, {});
  const Scene again = load_scene(folder_ / "again", {});
  EXPECT_NEAR(again.prepared_from_source.scale, world.scale, 1e-14);
  expect_same_camera(again.frames[0].camera, scene.frames[0].camera, 1e-12);
}

// B17. Bug put back: the mask of the first camera that has one for all; seen to fail.
TEST_F(N3dv, OneMaskACamera) {
  IngestOptions options;
  options.masks = folder_ / "masks";
  std::filesystem::create_directories(options.masks);
  std::vector<Image8> masks(3);
  for (size_t c : {1u, 2u}) {
    masks[c] = {32, 24, 1, std::vector<uint8_t>(32 * 24, 255)};
    std::fill_n(masks[c].data.begin(), 100 * c, uint8_t{0});
    write_png(options.masks / fmt::format("cam{:02}.png", c), masks[c]);
  }
  ingest(options);
  const Scene scene = load_scene(folder_ / "scene", {});
  for (size_t i = 0; i < 15; ++i) EXPECT_EQ(scene.frames[i].mask.data(), masks[i / 5].data) << i;
  // bug put back: a mask read for each frame; seen to fail
  for (size_t i = 1; i < 15; ++i)
    EXPECT_EQ(scene.frames[i].mask.shared() == scene.frames[i - 1].mask.shared(), i % 5 != 0) << i;
  const FrameMask sized = load_scene(folder_ / "scene", {.load_pixels = false}).frames[5].mask;
  EXPECT_EQ(sized.image().width, 32);
  EXPECT_TRUE(sized.data().empty());
  const json file = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(file["frames"][5]["mask_path"], "masks/cam01.png");
}

// Bugs put back, each seen to fail: masks counted from --start; the masks of the first camera for
// all; object numbers taken for black.
TEST_F(N3dv, AMaskAFrame) {
  IngestOptions options;
  options.masks = folder_ / "masks";
  const auto mask_of_frame = [](int frame, uint8_t used) {  // the first pixels are black
    Image8 mask{32, 24, 1, std::vector<uint8_t>(32 * 24, used)};
    std::fill_n(mask.data.begin(), frame + 1, uint8_t{0});
    return mask;
  };
  const auto write_masks = [&](const char* camera, uint8_t used, int first) {
    std::filesystem::create_directories(options.masks / camera);
    for (int n = 0; n < 5; ++n)
      write_png(options.masks / camera / fmt::format("{:05}.png", first + n),
                mask_of_frame(n, used));
  };
  write_masks("cam00", 255, 0);
  write_masks("cam01", 1, 0);
  write_masks("cam02", 255, 1);
  options.start = 0.079;  // two frames
  const IngestReport report = ingest(options);
  const Scene scene = load_scene(folder_ / "scene", {});
  ASSERT_EQ(scene.frames.size(), 9u);
  for (size_t i = 0; i < 9; ++i) {
    const int n = 2 + int(i % 3), c = int(i / 3);
    ASSERT_NEAR(scene.frames[i].image.data[200], numbered_grey(n, c), 1);
    EXPECT_EQ(scene.frames[i].mask.data(), mask_of_frame(n, 255).data) << i;
  }
  const json file = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(file["frames"][4]["mask_path"], "masks/cam01/00001.png");
  std::string notes;
  for (const std::string& note : report.notes) notes += note;
  EXPECT_NE(notes.find("cam02 are numbered from 1"), std::string::npos) << notes;
  EXPECT_NE(notes.find("3 masks have the numbers or colours of objects"), std::string::npos);
}

// Bug put back: the folder of masks is checked when all frames are decoded; seen to fail.
TEST_F(N3dv, AMissingFolderOfMasksIsNamedBeforeDecoding) {
  IngestOptions options;
  options.masks = folder_ / "nowhere";
  const auto decoding = [](std::string_view what, int64_t, int64_t) {
    throw std::runtime_error(std::string(what));
  };
  expect_input_error(
      [&] { ingest_capture(folder_ / "capture", folder_ / "scene", options, decoding); },
      {"nowhere: no such folder"});
}

TEST_F(N3dv, TheWindowIsOfTimesNotOfIndices) {
  IngestOptions options;
  options.start = 0.04;
  options.fps = 12.5;  // every other frame of 25 a second, from the second on
  EXPECT_EQ(ingest(options).frames, 6);
  const Scene scene = load_scene(folder_ / "scene", {});
  EXPECT_NEAR(scene.frames[0].image.data[200], numbered_grey(1, 0), 1);
  EXPECT_NEAR(scene.frames[1].image.data[200], numbered_grey(3, 0), 1);
}

// Bug put back: the start looked at when COLMAP has placed the cameras; seen to fail.
TEST_F(N3dv, AStartBeyondTheClipsIsRefusedBeforeColmap) {
  IngestOptions options;
  options.poses.source.kind = PoseSource::kColmap;
  options.start = 100;
  options.work = folder_ / "work";
  for (const std::vector<std::string>& cameras :
       {std::vector<std::string>{}, std::vector<std::string>{"cam00"}}) {
    options.cameras = cameras;
    expect_input_error([&] { ingest(options); }, {"--start 100 s is after the end", "pass less"});
    EXPECT_FALSE(std::filesystem::exists(options.work)) << cameras.size();
  }
}

// Failure mode A2: what moves at one speed has one velocity, whatever the frame rate, because times
// are of seconds; with index times the faster clip's would differ.
TEST_F(N3dv, TimesDoNotDependOnTheFrameRate) {
  const auto times = [&] {
    ingest();
    const Scene scene = load_scene(folder_ / "scene", {});
    std::vector<double> seconds;
    for (const Frame& frame : scene.frames)
      if (frame.camera_name == "cam01")
        seconds.push_back(scene.time_axis.origin + frame.time * scene.time_axis.duration);
    return seconds;
  };
  const std::vector<double> slow = times();
  for (int c = 0; c < 3; ++c) {
    TestVideo fast = numbered_video(9, c);
    for (int64_t i = 0; i < 9; ++i) fast.ticks.push_back(i * kTestTicksPerFrame / 2);
    write_video(video(c), fast);
  }
  const std::vector<double> fast = times();
  ASSERT_EQ(slow.size(), 5u);
  ASSERT_EQ(fast.size(), 9u);
  for (size_t i = 0; i < 5; ++i) EXPECT_NEAR(fast[2 * i], slow[i], 1e-12);
}

TEST_F(N3dv, AnotherShapeIsRefused) {
  for (LlffPose& pose : poses_) pose.camera.height = 60;
  write_llff_poses(folder_ / "capture/poses_bounds.npy", poses_);
  expect_input_error([&] { ingest(); }, {"cam00.mp4", "32x24", "64x60"});
}

TEST_F(N3dv, OneInstantIsStatic) {
  IngestOptions options;
  options.frames = 1;
  ingest(options);
  EXPECT_TRUE(load_scene(folder_ / "scene", {}).is_static);
}

// Bug put back: the old scene removed before the new one is complete; seen to fail.
TEST_F(N3dv, AFailureLeavesTheOldSceneAndNothingElse) {
  ingest();
  const std::string before = read_bytes(folder_ / "scene/transforms.json");
  const std::string bytes = read_bytes(video(2));
  write_bytes(video(2), bytes.substr(0, bytes.size() * 9 / 10));
  expect_input_error([&] { ingest(); }, {"cam02.mp4", "truncated after", "--cameras"});
  EXPECT_EQ(read_bytes(folder_ / "scene/transforms.json"), before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 2);
}

TEST_F(N3dv, ProgressIsReportedAndMayStop) {
  std::vector<std::string> doing;
  int64_t last = 0;
  ingest_capture(folder_ / "capture", folder_ / "scene", {},
                 [&](std::string_view what, int64_t done, int64_t total) {
                   if (!what.starts_with("decoding")) return;
                   doing.emplace_back(what);
                   EXPECT_EQ(total, 15);
                   EXPECT_EQ(done, ++last);
                 });
  EXPECT_EQ(doing.front(), "decoding cam00.mp4");
  EXPECT_EQ(last, 15);
  const auto stop = [](std::string_view, int64_t, int64_t) { throw std::runtime_error("stop"); };
  EXPECT_THROW(ingest_capture(folder_ / "capture", folder_ / "other", {}, stop),
               std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "other"));
}

}  // namespace
}  // namespace tessera
