// The function load_scene: times, compositing, sizes, and every invalid input it must name.
#include "ingest/prepared/scene_reader.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/images/alpha_and_mask.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

Scene load_with_times(const std::function<double(double)>& time) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {.train = 7, .time = time});
  return load_scene(folder.path(), {});
}

// A1. Bugs put back, each seen to fail: times taken as they are stated; times narrowed to float
// before the subtraction (at 1.7e9 s they all become one).
TEST(Times, AffineMapsAndEpochSecondsGiveTheSameNormalisedTimes) {
  const Scene unit = load_with_times([](double t) { return t; });
  const Scene affine = load_with_times([](double t) { return 2 * t + 5; });
  const Scene epoch = load_with_times([](double t) { return 1.7e9 + t; });
  EXPECT_EQ(affine.time_axis.origin, 5);
  EXPECT_EQ(affine.time_axis.duration, 2);
  EXPECT_EQ(epoch.time_axis.origin, 1.7e9);
  EXPECT_FALSE(epoch.is_static);
  for (size_t i = 0; i < unit.frames.size(); ++i) {
    EXPECT_NEAR(affine.frames[i].time, unit.frames[i].time, 1e-15);
    EXPECT_NEAR(epoch.frames[i].time, unit.frames[i].time, 1e-6);  // a double's step there: 2.4e-7
  }
  EXPECT_EQ(epoch.frames[6].time, 1.0);
}

TEST(Times, RangeIsThatOfAllSplits) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  edit_json(folder / "transforms_test.json", [](json& file) { file["frames"][1]["time"] = 3.0; });
  const Scene scene = load_scene(folder.path(), {});
  EXPECT_EQ(scene.time_axis.duration, 3);
  EXPECT_NEAR(scene.frames[3].time, 1.0 / 3, 1e-15);
  EXPECT_EQ(scene.frames[5].time, 1.0);
}

// Bug put back: the comparison of least and most time removed, so 0 / 0 is taken; seen to fail.
TEST(Times, AllEqualIsRefusedUnlessStaticIsAllowed) {
  const TemporaryFolder folder;
  SmallCapture capture;
  capture.time = [](double) { return 0.5; };
  write_dnerf(folder.path(), capture);
  expect_input_error([&] { load_scene(folder.path(), {}); },
                     {"all 6 frames have time 0.5", "--static", "correct the times"});
  SceneOptions options;
  options.allow_static = true;
  const Scene scene = load_scene(folder.path(), options);
  EXPECT_TRUE(scene.is_static);
  EXPECT_EQ(scene.time_axis.duration, 1);
  for (const Frame& frame : scene.frames) EXPECT_EQ(frame.time, 0);
}

TEST(Times, NoneIsStaticAndSomeIsAnError) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {.with_times = false});
  EXPECT_TRUE(load_scene(folder.path(), {}).is_static);
  edit_json(folder / "transforms_train.json", [](json& file) { file["frames"][1]["time"] = 0.5; });
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"frame 0", "has no time"});
  edit_json(folder / "transforms_train.json", [](json& f) { f["frames"][1]["time"] = "late"; });
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"frame 1", "time", "number"});
}

// B13, the loader's part. Bug put back: one time treated like several equal ones; seen to fail.
TEST(Scene, OneFrameOfOneCameraIsAStaticScene) {
  const TemporaryFolder folder;
  SmallCapture capture{.train = 1, .test = 0};
  capture.time = [](double) { return 0.25; };
  write_dnerf(folder.path(), capture);
  const Scene scene = load_scene(folder.path(), {});
  ASSERT_EQ(scene.frames.size(), 1u);
  EXPECT_TRUE(scene.is_static);
  EXPECT_EQ(scene.frames[0].time, 0);
  EXPECT_EQ(scene.time_axis.origin, 0.25);
}

// B20, the loader's part. Bug put back: a least size of 2 in the PNG reader; seen to fail.
TEST(Scene, OnePixelImagesLoad) {
  const TemporaryFolder folder;
  SmallCapture capture;
  capture.width = capture.height = 1;
  write_dnerf(folder.path(), capture);
  const Scene scene = load_scene(folder.path(), {});
  EXPECT_EQ(scene.frames[0].image.data.size(), 3u);
  EXPECT_EQ(scene.frames[0].camera.cx, 0.5);
  EXPECT_TRUE(std::isfinite(scene.frames[0].camera.fl_x));
}

// B19. Bugs put back, each seen to fail: colours multiplied by alpha twice; truncation for
// rounding; the background ignored.
TEST(Scene, KnownColoursOnBlackAndWhite) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  write_png(folder / "train/r_000.png", constant_image(8, 6, {200, 100, 51, 128}));
  SceneOptions options;
  const Scene black = load_scene(folder.path(), options);
  options.background = {255, 255, 255};
  const Scene white = load_scene(folder.path(), options);
  EXPECT_TRUE(black.had_alpha);
  EXPECT_EQ(black.background, (std::array<uint8_t, 3>{0, 0, 0}));
  EXPECT_EQ(white.background, (std::array<uint8_t, 3>{255, 255, 255}));
  EXPECT_EQ(black.frames[0].split, Split::kTrain);
  EXPECT_EQ(black.frames[4].split, Split::kTest);
  EXPECT_EQ(black.frames[0].image.width, 8);
  EXPECT_EQ(black.frames[0].image.height, 6);
  ASSERT_EQ(black.frames[0].image.channels, 3);
  // 200·128/255 = 100.39, 100·128/255 = 50.2, 51·128/255 = 25.6; 255·127/255 = 127 more on white
  EXPECT_EQ(black.frames[0].image.data, constant_image(8, 6, {100, 50, 26}).data);
  EXPECT_EQ(white.frames[0].image.data, constant_image(8, 6, {227, 177, 153}).data);
}

TEST(Scene, OpaqueAndGreyImagesPassThrough) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {.channels = 3});
  write_png(folder / "train/r_001.png", constant_image(8, 6, {77}));
  const Scene scene = load_scene(folder.path(), {});
  EXPECT_FALSE(scene.had_alpha);
  EXPECT_EQ(scene.frames[0].image.data, patterned_image(8, 6, 3, 0).data);
  EXPECT_EQ(scene.frames[1].image.data, constant_image(8, 6, {77, 77, 77}).data);
}

TEST(Scene, WithoutPixelsEverythingElseIsThere) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  SceneOptions options;
  options.load_pixels = false;
  const Scene with = load_scene(folder.path(), {}), without = load_scene(folder.path(), options);
  ASSERT_EQ(with.frames.size(), without.frames.size());
  EXPECT_TRUE(without.had_alpha);
  for (size_t i = 0; i < with.frames.size(); ++i) {
    EXPECT_TRUE(without.frames[i].image.data.empty());
    expect_same_camera(with.frames[i].camera, without.frames[i].camera, 0);
  }
}

// Bugs put back, each seen to fail: the first frames of the split, not spread ones; frames of the
// training split beside them; times of the few frames, not of the whole scene.
TEST(Scene, FewHeldOutFramesKeepTheirTimes) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {.train = 7, .test = 9});
  const Scene whole = load_scene(folder.path(), {}),
              few = load_scene(folder.path(), {.held_out = 3});
  const std::vector<int> test = whole.split_indices(Split::kTest);
  ASSERT_EQ(test.size(), 9u);
  ASSERT_EQ(few.frames.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const Frame& same = whole.frames[size_t(test[3 * i + 1])];
    EXPECT_EQ(few.frames[i].name, same.name);
    EXPECT_EQ(few.frames[i].time, same.time);
    EXPECT_EQ(few.frames[i].image.data, same.image.data);
  }
  EXPECT_EQ(load_scene(folder.path(), {.held_out = 20}).frames.size(), 9u);
}

/// A clip of 31 timesteps from 100 to 103 seconds.
void write_clip(const std::filesystem::path& folder) {
  SmallCapture capture{.train = 31, .test = 0};
  capture.time = [](double t) { return 100 + 3 * t; };
  write_dnerf(folder, capture);
}

// Bugs put back, each seen to fail: times of the whole clip; numbers of timesteps of the whole
// clip; the axis of the whole clip; points of other times; a sweep's cloud of the whole clip.
TEST(Scene, AWindowIsAClipOfItsOwn) {
  const TemporaryFolder folder;
  write_clip(folder.path());
  PointCloud points;
  points.position = {{0, 0, 1}, {0, 0, 2}, {0, 0, 3}, {0, 0, 4}};
  points.colour.resize(4);
  points.time = {0.5F, 0.1F, 0.9F, std::nanf("")};
  points.velocity = {{1, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  write_points(folder / "points.ply", points);
  const Scene whole = load_scene(folder.path(), {});
  SceneOptions options;
  options.window = Window{1, 3, 2};
  const Scene part = load_scene(folder.path(), options);
  ASSERT_EQ(part.frames.size(), 14u) << "timesteps 8 to 21";
  EXPECT_NEAR(part.time_axis.origin, 100.8, 1e-12);
  EXPECT_NEAR(part.time_axis.duration, 1.3, 1e-12);
  for (size_t i = 0; i < part.frames.size(); ++i) {
    const Frame &frame = part.frames[i], &same = whole.frames[i + 8];
    EXPECT_EQ(frame.name, same.name);
    EXPECT_EQ(frame.image.data, same.image.data);
    EXPECT_EQ(frame.timestep, int64_t(i));
    EXPECT_NEAR(part.time_axis.origin + frame.time * part.time_axis.duration,
                whole.time_axis.origin + same.time * whole.time_axis.duration, 1e-12);
  }
  EXPECT_EQ(part.frames.front().time, 0);
  EXPECT_EQ(part.frames.back().time, 1);
  ASSERT_EQ(part.points.position.size(), 2u) << "one is seen then, of one it is not known";
  EXPECT_NEAR(part.points.time[0], (0.5 * 3 - 0.8) / 1.3, 1e-6);
  EXPECT_NEAR(part.points.velocity[0].x, 1.3 / 3, 1e-6);
  points.still = {0, 0, 1, 1};
  write_points(folder / "points.ply", points);
  EXPECT_TRUE(load_scene(folder.path(), options).points.position.empty());

  options.window = Window{0, 16};
  expect_input_error([&] { load_scene(folder.path(), options); }, {"window 1/16", "31 timesteps"});
  edit_json(folder / "transforms_train.json", [](json& file) {
    for (json& frame : file["frames"]) frame["time"] = 5;
  });
  options.allow_static = true;
  expect_input_error([&] { load_scene(folder.path(), options); }, {"one timestep"});
}

// A readout is stated in seconds, and a view has it as a share of the clip. Bug put back: a window
// with the share of the whole clip; seen to fail.
TEST(Scene, ReadoutsKeepTheirSeconds) {
  const TemporaryFolder folder;
  write_clip(folder.path());
  edit_json(folder / "transforms_train.json", [](json& file) {
    file["rolling_shutter"] = -0.01;
    file["frames"][0]["readout"] = 0.02;
  });
  const Scene whole = load_scene(folder.path(), {});
  EXPECT_NEAR(whole.frames[0].camera.readout * whole.time_axis.duration, 0.02, 1e-12);
  EXPECT_NEAR(whole.frames[1].camera.readout * whole.time_axis.duration, -0.01, 1e-12);
  SceneOptions options;
  options.window = Window{0, 2};
  const Scene part = load_scene(folder.path(), options);
  EXPECT_LT(part.time_axis.duration, 0.75 * whole.time_axis.duration);
  EXPECT_NEAR(part.frames[0].camera.readout * part.time_axis.duration, 0.02, 1e-12);
}

// Bugs put back, each seen to fail: the error of the last bad frame reported (not the first);
// require_image() returning the stated path without looking.
TEST(BadScene, ImagesThatAreMissingOrDamagedAreNamed) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  const std::string bytes = read_bytes(folder / "train/r_001.png");
  write_bytes(folder / "train/r_001.png", bytes.substr(0, bytes.size() / 2));
  write_bytes(folder / "train/r_003.png", "");
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"r_001.png"});
  write_bytes(folder / "train/r_001.png", bytes);
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"r_003.png", "empty"});
  std::filesystem::remove(folder / "train/r_003.png");
  expect_input_error([&] { load_scene(folder.path(), {}); },
                     {"transforms_train.json", "frame 3", "no such image"});
  write_bytes(folder / "train/r_003.jpg", "x");
  expect_input_error([&] { load_scene(folder.path(), {}); },
                     {"r_003.jpg", "not a PNG", "tessera ingest"});
}

TEST(BadScene, PosesThatCannotBeAreNamed) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  const std::string good = read_bytes(folder / "transforms_train.json");
  for (const char* word : {"NaN", "Infinity", "-Infinity"}) {
    std::string bad = good;
    bad.replace(bad.rfind("1.0"), 3, word);  // last row, so the number parsed is not a pose's
    bad.replace(bad.find("0.0", bad.find("transform_matrix")), 3, word);
    write_bytes(folder / "transforms_train.json", bad);
    expect_input_error([&] { load_scene(folder.path(), {}); },
                       {"frame 0 (./train/r_000)", "transform_matrix"});
  }
  write_bytes(folder / "transforms_train.json", good);
  edit_json(folder / "transforms_train.json", [](json& file) {
    for (int c = 0; c < 3; ++c) file["frames"][2]["transform_matrix"][1][size_t(c)] = 0.0;
  });
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"frame 2", "singular"});
  edit_json(folder / "transforms_train.json",
            [](json& file) { file["frames"][2].erase("transform_matrix"); });
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"frame 2", "4x4"});
}

TEST(BadScene, NothingToTrainOnAndListedTwice) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  edit_json(folder / "transforms_train.json", [](json& file) {
    for (json& frame : file["frames"]) frame["split"] = "val";
  });
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"'train'"});
  edit_json(folder / "transforms_train.json",
            [](json& file) { file["frames"][1]["file_path"] = "train/r_000"; });
  Scene scene;
  expect_input_error(
      [&] {
        edit_json(folder / "transforms_train.json",
                  [](json& file) { file["frames"][2]["file_path"] = "train/r_000"; });
        scene = load_scene(folder.path(), {});
      },
      {"frame 2", "listed twice"});
}

}  // namespace
}  // namespace tessera
