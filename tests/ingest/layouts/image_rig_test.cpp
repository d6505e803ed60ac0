// Numbered images of several cameras are converted to a prepared scene and loaded as a Scene, equal
// to that of videos. The names that make a rig are tested in image_sequences_test.cpp.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/ingest.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;
using std::filesystem::path;

constexpr int kRigWidth = 32, kRigHeight = 24;

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
      cameras.push_back({{"name", std::to_string(c)},
                         {"transform_matrix", gl_matrix(looking_at_origin({4.0, 0.5 * c, 1.0}))}});
    }
    const json file{{"fl_x", 50},     {"fl_y", 50},      {"cx", 16},          {"cy", 12},
                    {"w", kRigWidth}, {"h", kRigHeight}, {"cameras", cameras}};
    write_bytes(folder_ / "cameras.json", file.dump());
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
  IngestReport ingest() {
    IngestOptions options;
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

// Bug put back: the clip is what all cameras show; seen to fail.
TEST_F(ImageRig, ACameraThatBeginsLateOrStopsEarlyGivesWhatItHas) {
  for (const bool late : {false, true}) {
    write("cam{c}/{t:06}.png");
    const int last = late ? 3 : 5;
    for (int n = last - 3; n < last; ++n)
      std::filesystem::remove(file_of("cam{c}/{t:06}.png", 2, n));
    EXPECT_EQ(ingest().warnings.at(0),
              "cam2 (0.033 s): a part of the 0.133 s of the clip; the other cameras alone show "
              "the rest");
    const Scene scene = this->scene();
    ASSERT_EQ(scene.frames.size(), 12u);
    for (const Frame& frame : scene.frames) {
      if (frame.camera_name != "cam2") continue;
      EXPECT_EQ(frame.image.data[100], grey(2, int(frame.timestep)));
      EXPECT_EQ(frame.timestep >= 3, late);
    }
  }
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

}  // namespace
}  // namespace tessera
