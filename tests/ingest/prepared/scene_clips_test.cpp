// A prepared scene whose frames stay in the source videos: the same pixels, times, cameras and
// masks as one of images, by its whole and by windows, and what is refused.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ingest/derived/unpacked_scene.h"
#include "ingest/files/png.h"
#include "ingest/ingest.h"
#include "ingest/prepared/scene_clip.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

/// Four videos of 96×64 with lenses: one turned by its flag, one of uneven times.
class SceneClips : public ::testing::Test {
 protected:
  static constexpr int kCameras = 4, kFrames = 40;
  void SetUp() override {
    if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
    set_clip_reader(video_clip_reader());
    std::filesystem::create_directories(folder_ / "capture");
    for (int c = 0; c < kCameras; ++c) add_camera(c);
    write_bytes(folder_ / "cameras.json", json{{"cameras", cameras_}}.dump());
    std::filesystem::create_directories(folder_ / "masks");
    Image8 mask{96, 64, 1, std::vector<uint8_t>(size_t{96} * 64, 255)};
    std::fill_n(mask.data.begin(), 96 * 20, uint8_t{0});
    write_png(folder_ / "masks/cam00.png", mask);
    write_png(folder_ / "masks/cam01.png", mask);
    write_png(folder_ / "masks/cam03.png", mask);
    Image8 turned{64, 96, 1, std::vector<uint8_t>(size_t{96} * 64, 255)};
    write_png(folder_ / "masks/cam02.png", turned);
  }
  void TearDown() override { set_clip_reader(nullptr); }

  void add_camera(int c) {
    const std::string name = fmt::format("cam{:02}", c);
    TestVideo video;
    video.keyframe_distance = 9;
    for (int i = 0; i < kFrames; ++i) {
      video.frames.push_back(coded_image(96, 64, 100 * c + i));
      if (c == 1) video.ticks.push_back(512 * i + 40 * (i % 3));
    }
    if (c == 2) video.display_matrix = {{0, 1, -1, 0}};
    write_video(folder_ / ("capture/" + name + ".mp4"), video);
    const int width = c == 2 ? 64 : 96, height = c == 2 ? 96 : 64;
    cameras_.push_back({{"name", name},
                        {"transform_matrix", gl_matrix(looking_at_origin({4.0, c - 1.5, 1.0}))},
                        {"fl_x", 90},
                        {"fl_y", 91},
                        {"cx", width / 2 + 1},
                        {"cy", height / 2},
                        {"k1", -0.08},
                        {"p1", 0.002},
                        {"w", width},
                        {"h", height}});
  }
  IngestReport ingest(const std::string& out, FramesAs frames_as, double scale = 0.75) {
    IngestOptions options;
    options.poses.source = {PoseSource::kCameras, folder_ / "cameras.json"};
    options.sync.method = SyncMethod::kNone;
    options.cloud = CloudDensity::kNone;
    options.masks = folder_ / "masks";
    options.scale = scale;
    options.start = 0.1;
    options.duration = 1.2;
    options.frames_as = frames_as;
    options.check_cameras = true;
    return ingest_capture(folder_ / "capture", folder_ / out, options, {});
  }
  static void expect_same(const Scene& scene, const Scene& images) {
    EXPECT_EQ(scene.time_axis.origin, images.time_axis.origin);
    EXPECT_EQ(scene.time_axis.duration, images.time_axis.duration);
    ASSERT_EQ(scene.frames.size(), images.frames.size());
    for (size_t i = 0; i < scene.frames.size(); ++i) {
      const Frame &frame = scene.frames[i], &image = images.frames[i];
      EXPECT_EQ(frame.name, image.name);
      EXPECT_EQ(frame.camera_name, image.camera_name);
      EXPECT_EQ(frame.split, image.split);
      EXPECT_EQ(frame.frame_number, image.frame_number);
      EXPECT_EQ(frame.time, image.time) << frame.name;
      EXPECT_EQ(frame.timestep, image.timestep) << frame.name;
      EXPECT_TRUE(frame.camera == image.camera) << frame.name;
      EXPECT_TRUE(frame.image.data == image.image.data) << frame.name;
      EXPECT_TRUE(frame.mask.data() == image.mask.data()) << frame.name;
    }
  }

  TemporaryFolder folder_;
  json cameras_ = json::array();
};

// Bug put back: images without the lens removed; seen to fail. Finds also: scaled before that;
// times by rate and number of the frame; frames of a window by their place in the whole clip; the
// clips in another order than their frames.
TEST_F(SceneClips, AreTheSameSceneAsItsImages) {
  const IngestReport images = ingest("images", FramesAs::kPng);
  const IngestReport clips = ingest("clips", FramesAs::kVideo);
  EXPECT_EQ(clips.frames, images.frames);
  EXPECT_EQ(clips.warnings, images.warnings);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "clips/cam00"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "clips/masks/cam00.png"));
  const json file = json::parse(read_bytes(folder_ / "clips/transforms.json"));
  EXPECT_EQ(file["tessera"]["format_version"], 2);
  EXPECT_EQ(file["frames"], json::array()) << "older programs refuse it by its version";
  EXPECT_EQ(file["tessera"]["clips"][0]["ticks"].size(), 1u) << "a constant rate is one run";
  SceneOptions options;
  expect_same(load_scene(folder_ / "clips", options), load_scene(folder_ / "images", options));
  options.window = Window{1, 3, 2};
  expect_same(load_scene(folder_ / "clips", options), load_scene(folder_ / "images", options));
  options.window.reset();
  options.timesteps = {{20, 3}};
  expect_same(load_scene(folder_ / "clips", options), load_scene(folder_ / "images", options));
  options.timesteps.reset();
  options.load_pixels = false;
  expect_same(load_scene(folder_ / "clips", options), load_scene(folder_ / "images", options));
}

// Finds: the axis of the whole clip; poses that were read and are written again.
TEST_F(SceneClips, UnpackToTheSameScene) {
  ingest("clips", FramesAs::kVideo);
  const Window window{1, 3, 2};
  unpack_scene(folder_ / "clips", window, folder_ / "part", [](int64_t, int64_t) {});
  SceneOptions options;
  const Scene part = load_scene(folder_ / "part", options);
  const auto masks = std::filesystem::directory_iterator(folder_ / "part/masks");
  EXPECT_EQ(std::distance(masks, {}), kCameras);
  options.window = window;
  expect_same(part, load_scene(folder_ / "clips", options));
  expect_input_error([&] { unpack_scene(folder_ / "capture", {}, folder_ / "x", {}); },
                     {"no prepared scene"});
}

// Bug put back: the path of a mask is joined to the output as it is; seen to fail.
TEST_F(SceneClips, UnpackedMasksStayInTheFolder) {
  ingest("clips", FramesAs::kVideo);
  const std::filesystem::path clips = folder_ / "clips";
  edit_json(clips / "transforms.json", [&](json& file) {
    json& mask = file["tessera"]["clips"][1]["mask_path"];
    std::filesystem::copy(clips / mask.get<std::string>(), folder_ / "own.png");
    mask = "../own.png";
  });
  unpack_scene(clips, {}, folder_ / "a/part", [](int64_t, int64_t) {});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a/own.png"));
  expect_same(load_scene(folder_ / "a/part", {}), load_scene(clips, {}));
}

// Finds: only the existence of a source is checked; only its size; a scene of clips is converted
// again into one without frames.
TEST_F(SceneClips, NameASourceThatIsNotWhatItWas) {
  ingest("clips", FramesAs::kVideo);
  expect_input_error([&] { ingest_capture(folder_ / "clips", folder_ / "again", {}, {}); },
                     {"prepared scene", "prepare that capture again"});
  set_clip_reader(nullptr);
  expect_input_error([&] { load_scene(folder_ / "clips", {}); }, {"reads no videos", "unpack"});
  const std::string video = read_bytes(folder_ / "capture/cam01.mp4");
  std::string other = video;
  other[other.size() / 2] = char(other[other.size() / 2] + 1);
  write_bytes(folder_ / "capture/cam01.mp4", other);
  expect_input_error([&] { load_scene(folder_ / "clips", {}); },
                     {"cam01.mp4", "another video", "prepare the capture again"});
  write_bytes(folder_ / "capture/cam01.mp4", video);
  std::ofstream(folder_ / "capture/cam01.mp4", std::ios::app) << "more";
  expect_input_error([&] { load_scene(folder_ / "clips", {}); },
                     {"cam01.mp4", "bytes", "prepare the capture again"});
  std::filesystem::remove(folder_ / "capture/cam01.mp4");
  expect_input_error([&] { load_scene(folder_ / "clips", {}); }, {"cam01.mp4", "camera cam01"});
}

// Finds: ticks that go back are taken; an exception of the JSON library.
TEST_F(SceneClips, RefuseDamagedEntries) {
  ingest("clips", FramesAs::kVideo);
  const std::string whole = read_bytes(folder_ / "clips/transforms.json");
  const auto refused = [&](const std::function<void(json&)>& change, const std::string& part) {
    write_bytes(folder_ / "clips/transforms.json", whole);
    edit_json(folder_ / "clips/transforms.json",
              [&](json& file) { change(file["tessera"]["clips"][1]); });
    expect_input_error([&] { load_scene(folder_ / "clips", {}); }, {"clip 1", part});
  };
  refused([](json& clip) { clip["ticks"] = {{10, 512, 4}, {20, 512, 4}}; }, "ticks");
  refused([](json& clip) { clip["ticks"] = {{10, 0, 4}}; }, "ticks");
  refused([](json& clip) { clip["ticks"] = {{10, 1, int64_t{1} << 40}}; }, "ticks");
  refused([](json& clip) { clip.erase("files"); }, "files");
  refused([](json& clip) { clip["time_base"] = {1, 0}; }, "time_base");
  refused([](json& clip) { clip["camera"] = "cam00"; }, "another clip of camera cam00");
  refused([](json& clip) { clip["stored"].erase("fl_x"); }, "fl_x");
  refused([](json& clip) { clip["mask_path"] = "masks/none.png"; }, "none.png");
  refused([](json& clip) { clip["field_of_view"] = "auto"; }, "field_of_view");
  refused([](json& clip) { clip["field_of_view"] = 1; }, "field_of_view");
}

// Finds: --fit-exposure is passed over.
TEST_F(SceneClips, RefuseWhatChangesPixels) {
  IngestOptions options;
  options.poses.source = {PoseSource::kCameras, folder_ / "cameras.json"};
  options.frames_as = FramesAs::kVideo;
  options.fit_exposure = true;
  expect_input_error([&] { ingest_capture(folder_ / "capture", folder_ / "scene", options, {}); },
                     {"--frames-as video", "--fit-exposure"});
}

}  // namespace
}  // namespace tessera
