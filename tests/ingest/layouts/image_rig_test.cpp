// Numbered images of several cameras are converted to a prepared scene and loaded as a Scene, equal
// to that of videos. The names that make a rig are tested in image_sequences_test.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ingest/checks/thinned_scene.h"
#include "ingest/files/png.h"
#include "ingest/images/image_source.h"
#include "ingest/ingest.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/poses/pose_matrix.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;
using std::filesystem::path;

constexpr int kRigWidth = 32, kRigHeight = 24;

json entry_of(const std::string& name, int camera) {
  return {{"name", name},
          {"transform_matrix", gl_matrix(looking_at_origin({4.0, 0.5 * camera, 1.0}))},
          {"fl_x", 50},
          {"fl_y", 50},
          {"cx", 16},
          {"cy", 12},
          {"w", kRigWidth},
          {"h", kRigHeight}};
}

/// Images numbered 100 … of cameras 0, 1, 2, each of one grey, and their poses beside them.
class ImageRig : public ::testing::Test {
 protected:
  void write(const std::string& pattern, int channels = 3) {
    json cameras = json::array();
    for (int c = 0; c < 3; ++c) {
      for (int n = 0; n < 5; ++n) {
        const path file = file_of(pattern, c, n);
        std::filesystem::create_directories(file.parent_path());
        write_png(file, constant_image(kRigWidth, kRigHeight, pixel(c, n, channels)));
      }
      cameras.push_back(entry_of(std::to_string(c), c));
    }
    write_bytes(folder_ / "cameras.json", json{{"cameras", cameras}}.dump());
  }
  path file_of(const std::string& pattern, int camera, int frame) {
    return folder_ / "capture" /
           fmt::format(fmt::runtime(pattern), fmt::arg("c", camera), fmt::arg("t", 100 + frame));
  }
  static uint8_t grey(int camera, int frame) { return uint8_t(40 * camera + 10 * frame + 5); }
  static std::vector<uint8_t> pixel(int camera, int frame, int channels) {
    std::vector<uint8_t> pixel(size_t(channels), grey(camera, frame));
    if (channels == 4) pixel[3] = 0;
    return pixel;
  }
  IngestReport ingest(IngestOptions options = {}) {
    options.poses.source = {PoseSource::kCameras, folder_ / "cameras.json"};
    options.keep_world = true;
    options.cloud = CloudDensity::kNone;
    return ingest_capture(folder_ / "capture", folder_ / "scene", options, {});
  }
  Scene scene() { return load_scene(folder_ / "scene", {}); }

  TemporaryFolder folder_;
};

// Bugs put back, each seen to fail: the place in the list for the number of a frame; clocks
// measured by motion.
TEST_F(ImageRig, FramesCamerasTimesAndSplits) {
  write("ims/{c}/{t:06}.png");
  std::filesystem::remove(file_of("ims/{c}/{t:06}.png", 1, 2));
  const IngestReport report = ingest();
  EXPECT_EQ(report.layout, CaptureLayout::kSequences);
  EXPECT_EQ(report.frames, 14);
  EXPECT_EQ(report.cameras, 3);
  EXPECT_EQ(report.scored, "will be scored: 4 test views (camera 1)");
  ASSERT_EQ(report.notes.size(), 2u);
  EXPECT_EQ(report.notes[1], "clocks: the times of the files are taken as they are");
  for (const char* part : {"3 cameras that film together", "N / 30 s", "--layout photos"})
    EXPECT_NE(report.notes[0].find(part), std::string::npos) << report.notes[0];
  EXPECT_NE(report.warnings.at(0).find("camera 1 has a gap"), std::string::npos);
  const Scene scene = this->scene();
  ASSERT_EQ(scene.frames.size(), 14u);
  EXPECT_NEAR(scene.time_axis.duration, 4.0 / 30, 1e-12);
  for (const Frame& frame : scene.frames) {
    const int c = frame.camera_name[0] - '0';
    const int n = int(std::lround(frame.time * 4));
    EXPECT_NEAR(frame.time, n / 4.0, 1e-12) << frame.name;
    EXPECT_EQ(frame.image.data[100], grey(c, n)) << frame.name;
    EXPECT_EQ(frame.split, c == 1 ? Split::kTest : Split::kTrain) << "the innermost";
    EXPECT_NEAR(frame.camera.position().y, 0.5 * c, 1e-12);
  }
  const json file = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(file["tessera"]["cameras"][2]["time_offset"], 0);
  for (const std::string& warning : report.warnings)  // clocks are not in doubt
    EXPECT_EQ(warning.find("clock"), std::string::npos) << warning;
}

// Photos that were taken for a rig find no poses. Bug put back: the layout noted only where all
// goes well; seen to fail.
TEST_F(ImageRig, WhereNoPosesAreFoundTheReadingIsSaid) {
  write("ims/{c}/{t:06}.png");
  ::setenv("TESSERA_COLMAP", "/bin/false", 1);
  const auto ingest_with = [&](std::optional<ImageLayout> layout) {
    IngestOptions options;
    options.image_layout = layout;
    ingest_capture(folder_ / (layout ? "capture/ims/0" : "capture"), folder_ / "scene", options,
                   {});
  };
  expect_input_error([&] { ingest_with({}); },
                     {"3 cameras that film together", "N / 30 s", "--layout photos"});
  expect_input_error([&] { ingest_with(ImageLayout::kMoving); }, {"one camera that moves"});
  ::unsetenv("TESSERA_COLMAP");
}

// Bug put back: no length looked at before COLMAP; seen to fail (COLMAP is missed first).
TEST_F(ImageRig, ACameraOfOneImageIsNamedBeforeColmap) {
  write("cam{c}/{t:06}.png");
  for (int n = 1; n < 5; ++n) std::filesystem::remove(file_of("cam{c}/{t:06}.png", 1, n));
  ::setenv("TESSERA_COLMAP", "/bin/false", 1);
  const std::vector<std::string> parts{"cam1 limits the clip to 1 of 5 timesteps",
                                       "--cameras cam0,cam2"};
  IngestOptions options;
  for (const bool sample : {false, true}) {
    options.sample = sample;
    expect_input_error([&] { ingest_capture(folder_ / "capture", folder_ / "scene", options, {}); },
                       parts);
  }
  ::unsetenv("TESSERA_COLMAP");
}

// Bug put back: --fps dropping images, as of videos; seen to fail.
TEST_F(ImageRig, RateAndChoiceOfFrames) {
  write("camera_{c}_img_{t}.png");
  edit_json(folder_ / "cameras.json", [](json& file) {
    for (json& camera : file["cameras"])
      camera["name"] = "camera_" + camera["name"].get<std::string>();
  });
  IngestOptions options;
  options.fps = 15;
  options.frames = 3;
  options.held_out = {"camera_2"};
  EXPECT_EQ(ingest(options).frames, 9);
  const Scene scene = this->scene();
  EXPECT_NEAR(scene.time_axis.duration, 2.0 / 15, 1e-12);
  EXPECT_EQ(scene.frames[8].image.data[0], grey(2, 2));
  EXPECT_EQ(scene.frames[8].split, Split::kTest);
  options.poses.source = {PoseSource::kCameras, folder_ / "cameras.json"};
  options.sample = true;
  const IngestReport sample = ingest_capture(folder_ / "capture", folder_ / "sample", options, {});
  EXPECT_EQ(sample.layout, CaptureLayout::kSequences);
}

// Bug put back: alpha composited on black in the prepared images; seen to fail.
TEST_F(ImageRig, AlphaIsKept) {
  write("{c}/{t:06}.png", 4);
  ingest();
  SceneOptions white;
  white.background = {255, 255, 255};
  EXPECT_EQ(load_scene(folder_ / "scene", white).frames[7].image.data[50], 255);
  EXPECT_TRUE(scene().had_alpha);
}

TEST_F(ImageRig, BadImagesAndMissingCamerasAreNamed) {
  write("cam{c}/{t:06}.png");
  const auto rename = [&](const std::string& before) {
    int number = 0;
    edit_json(folder_ / "cameras.json", [&](json& file) {
      for (json& camera : file["cameras"]) camera["name"] = before + std::to_string(number++);
    });
  };
  rename("cam1");
  expect_input_error([&] { ingest(); },
                     {"has no camera for cam0, cam1, cam2", "it has cam10, cam11, cam12"});
  rename("cam");
  const path file = file_of("cam{c}/{t:06}.png", 2, 3);
  write_png(file, constant_image(kRigWidth, kRigHeight / 2, {1, 2, 3}));
  expect_input_error([&] { ingest(); }, {file.string(), "is 32x12", "camera cam2 is 32x24"});
  write_bytes(file, "no image");
  expect_input_error([&] { ingest(); }, {file.string()});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene"));
}

// A row a camera, as N3DV's, beside images that a video was cut into.
TEST_F(ImageRig, RowsOfPosesBounds) {
  write("cam{c:02}/images/{t:04}.png");
  std::vector<LlffPose> poses;
  for (int i = 0; i < 3; ++i) {
    const json matrix = gl_matrix(looking_at_origin({4.0, 0.5 * i, 1.0}));
    PoseRows rows{};
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) rows[r][c] = matrix[r][c];
    Camera camera{2 * kRigWidth, 2 * kRigHeight, 100, 100, kRigWidth, kRigHeight, {}, {}};
    set_pose(camera, rows, "test");
    poses.push_back({camera, 1, 9});
  }
  write_llff_poses(folder_ / "capture/poses_bounds.npy", poses);
  IngestOptions options;
  options.keep_world = true;
  options.cloud = CloudDensity::kNone;
  EXPECT_EQ(ingest_capture(folder_ / "capture", folder_ / "scene", options, {}).frames, 15);
  const Scene scene = this->scene();
  expect_same_camera(scene.frames[14].camera, poses[2].camera.resized(kRigWidth, kRigHeight),
                     1e-12);
}

// The real layout: ims/C/TTTTTT.jpg, cameras by the names of their folders.
TEST(ImageRigData, FoldersOfBasketball) {
  TESSERA_NEED_DATA(basketball, "basketball");
  const TemporaryFolder folder;
  json cameras = json::array(), stated;
  std::ifstream(basketball / "transforms_train.json") >> stated;
  for (const char* name : {"1", "2", "3"}) {
    std::filesystem::create_directories(folder / "capture/ims" / name);
    for (int n = 0; n < 4; ++n) {
      const std::string file = fmt::format("ims/{}/{:06}.jpg", name, n);
      std::filesystem::create_symlink(std::filesystem::canonical(basketball / file),
                                      folder / "capture" / file);
    }
    const std::string first = fmt::format("ims/{}/000000", name);
    for (json entry : stated["frames"])
      if (entry["file_path"].get<std::string>().find(first) != std::string::npos) {
        entry["name"] = name;
        cameras.push_back(entry);
      }
  }
  ASSERT_EQ(cameras.size(), 3u);
  stated.erase("frames");
  stated["cameras"] = cameras;
  write_bytes(folder / "cameras.json", stated.dump());
  IngestOptions options;
  options.poses.source = {PoseSource::kCameras, folder / "cameras.json"};
  options.keep_world = true;
  options.cloud = CloudDensity::kNone;
  const IngestReport report = ingest_capture(folder / "capture", folder / "scene", options, {});
  EXPECT_EQ(report.layout, CaptureLayout::kSequences);
  EXPECT_EQ(report.frames, 12);
  EXPECT_EQ(report.scored, "will be scored: 4 test views (camera 1)");
  const Scene scene = load_scene(folder / "scene", {});
  EXPECT_EQ(scene.frames[11].image.data, read_image(basketball / "ims/3/000003.jpg").data);
  EXPECT_NEAR(scene.time_axis.duration, 0.1, 1e-12);
}

}  // namespace
}  // namespace tessera
