// Rigs of videos and of numbered images that are posed by the calibration that lies beside them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/ingest.h"
#include "tests/ingest/colmap/colmap_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kClips = 3, kFrames = 4;

Stand stand_of(int camera) {
  return looking_at_origin({4.0, 0.5 * camera, 1.0});
}

/// cam01 … as folders of images, or as videos; a program `colmap` that fails.
class CalibratedRig : public ::testing::Test {
 protected:
  void SetUp() override { ::setenv("TESSERA_COLMAP", "/bin/false", 1); }
  void TearDown() override { ::unsetenv("TESSERA_COLMAP"); }

  void write_images() {
    for (int c = 0; c < kClips; ++c) {
      const auto camera = folder_ / fmt::format("capture/cam{:02}", c + 1);
      std::filesystem::create_directories(camera);
      for (int t = 0; t < kFrames; ++t)
        write_png(camera / fmt::format("{:04}.png", t), patterned_image(32, 24, 3, 7 * c + t));
    }
  }
  void write_videos() {
    std::filesystem::create_directories(folder_ / "capture");
    for (int c = 0; c < kClips; ++c)
      write_video(folder_ / fmt::format("capture/cam{:02}.mp4", c + 1), numbered_video(kFrames, c));
  }
  /// A model whose images are called by `pattern` with the number of a camera, from 1.
  static WrittenModel model(const std::string& pattern) {
    WrittenModel model = small_colmap_model(kClips);
    for (int c = 0; c < kClips; ++c) {
      model.images[size_t(c)].name = fmt::format(fmt::runtime(pattern), c + 1);
      stand_at(model.images[size_t(c)], stand_of(c));
    }
    return model;
  }
  IngestReport ingest(const PoseSource& poses = {}, IngestOptions options = {}) {
    options.poses.source = poses;
    options.keep_world = true;
    options.sync.method = SyncMethod::kNone;
    options.cloud = options.cloud.value_or(CloudDensity::kSparse);
    std::filesystem::remove_all(folder_ / "scene");
    return ingest_capture(folder_ / "capture", folder_ / "scene", options, {});
  }
  /// The scene has the cameras of the rig where they stand.
  void expect_posed(size_t points) const {
    const Scene scene = load_scene(folder_ / "scene", {});
    ASSERT_EQ(scene.frames.size(), size_t(kClips * kFrames));
    for (const Frame& frame : scene.frames) {
      const int c = frame.camera_name.back() - '1';
      EXPECT_NEAR(frame.camera.position().y, 0.5 * c, 1e-9) << frame.name;
      EXPECT_NEAR(frame.camera.fl_x, 40, 1e-9);
    }
    EXPECT_EQ(scene.points.position.size(), points);
  }

  TemporaryFolder folder_;
};

// Bugs put back, each seen to fail: a model beside videos taken for that of photos; its points
// left out.
TEST_F(CalibratedRig, VideosWithAModelInEachPlace) {
  if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
  write_videos();
  for (const char* place : {"sparse/0", "sparse", "sparse_", "colmap/sparse/0", ""}) {
    SCOPED_TRACE(place);
    const auto at_place = (folder_ / "capture" / place).lexically_normal();
    write_colmap_txt(at_place, model("cam{:02}.png"));
    for (const auto source : {PoseSource::kFound, PoseSource::kColmap}) {
      const IngestReport report = ingest({source});
      EXPECT_EQ(report.layout, CaptureLayout::kVideos);
      EXPECT_THAT(report.notes, Contains(HasSubstr("poses of 3 cameras from ")));
      EXPECT_THAT(report.warnings, Each(Not(HasSubstr("calibration"))));
      expect_posed(3);
    }
    for (const char* file : {"cameras.txt", "images.txt", "points3D.txt"})
      std::filesystem::remove(at_place / file);
  }
}

// Bug put back: the points of the model left out; seen to fail.
TEST_F(CalibratedRig, ImagesWithANumberedModel) {
  write_images();
  for (const char* place : {"capture/sparse", "capture/sparse_"}) {
    write_colmap_bin(folder_ / place, model("image{}.png"));
    const IngestReport report = ingest();
    EXPECT_EQ(report.layout, CaptureLayout::kSequences);
    EXPECT_THAT(report.notes, Contains(HasSubstr("(COLMAP model)")));
    expect_posed(3);
    std::filesystem::remove_all(folder_ / place);
  }
  std::filesystem::rename(folder_ / "capture", folder_ / "images");
  std::filesystem::create_directories(folder_ / "capture");
  std::filesystem::rename(folder_ / "images", folder_ / "capture/images");
  write_colmap_bin(folder_ / "capture/sparse/0", model("cam{:02}.png"));
  EXPECT_EQ(ingest().layout, CaptureLayout::kSequences);
  expect_posed(3);
}

// Bug put back: each model beside clips taken for their calibration; seen to fail.
TEST_F(CalibratedRig, PhotosWithAModelStayPhotos) {
  write_images();
  const WrittenModel photos = small_colmap_model(4);
  write_photo_set(folder_ / "capture", photos);
  EXPECT_EQ(detect_layout(folder_ / "capture"), CaptureLayout::kColmap);
  if (!can_encode_video()) return;
  write_videos();
  EXPECT_EQ(detect_layout(folder_ / "capture"), CaptureLayout::kColmap);
}

// Bug put back: an error where a model that was found does not fit; seen to fail. COLMAP is called,
// which fails, and the error has the reason.
TEST_F(CalibratedRig, AModelThatDoesNotFitIsNamedAndPosesAreEstimated) {
  write_images();
  write_colmap_bin(folder_ / "capture/sparse_", model("view{}.png"));
  ingest();
  for (const char* pattern : {"image{}0.png", "photo_{}x.png"}) {
    write_colmap_bin(folder_ / "capture/sparse_", model(pattern));
    expect_input_error([&] { ingest(); },
                       {"/bin/false", "sparse_: has no camera for cam01, cam02, cam03",
                        "this calibration is not used"});
    expect_input_error(
        [&] {
          ingest({PoseSource::kCameras, folder_ / "capture/sparse_"});
        },
        {"sparse_: has no camera for cam01, cam02, cam03"});
  }
  WrittenModel moving = model("cam{:02}/0000.png");
  moving.images.push_back(moving.images[0]);
  moving.images.back().name = "cam01/0001.png";
  write_colmap_bin(folder_ / "capture/sparse_", moving);
  ingest();
  expect_posed(3);
  moving.images.back().translation.x += 1;
  write_colmap_bin(folder_ / "capture/sparse_", moving);
  expect_input_error(
      [&] {
        ingest({PoseSource::kCameras, folder_ / "capture/sparse_"});
      },
      {"a camera that moves"});
}

json rig_json() {
  json cameras = json::object();
  for (int c = 0; c < kClips; ++c) {
    const Stand stand = stand_of(c);
    json rotation = json::array(), translation = json::array();
    for (const glm::dvec3& axis : {stand.right, -stand.up, stand.forward}) {
      rotation.push_back({axis.x, axis.y, axis.z});
      translation.push_back(
          -(axis.x * stand.centre.x + axis.y * stand.centre.y + axis.z * stand.centre.z));
    }
    cameras[fmt::format("cam{:02}", c + 1)] = {
        {"K", {{40, 0, 15.5}, {0, 40, 11.5}, {0, 0, 1}}}, {"R", rotation}, {"T", translation}};
  }
  return cameras;
}

// Bug put back: files that could be read named as those that cannot; seen to fail.
TEST_F(CalibratedRig, OtherCalibrationsAreNamedInOneLine) {
  write_images();
  write_colmap_bin(folder_ / "capture/sparse_", model("image{}.png"));
  write_bytes(folder_ / "capture/cameras.json", rig_json().dump());
  write_bytes(folder_ / "capture/export.csv", "#name,x,y,alt,heading,pitch,roll\n");
  write_bytes(folder_ / "capture/chunk.xml", "<?xml?>\n<document><chunk></chunk></document>\n");
  write_bytes(folder_ / "capture/readings.csv", "1,2,3\n");
  const IngestReport report = ingest();
  expect_posed(3);
  const auto is_of_calibration = [](const std::string& line) {
    return line.find("not used") != std::string::npos || line.find("not read") != std::string::npos;
  };
  ASSERT_EQ(std::count_if(report.warnings.begin(), report.warnings.end(), is_of_calibration), 1);
  for (const char* part : {"cameras.json is not used", "--poses ", "/cameras.json; ",
                           "chunk.xml, export.csv are not read"})
    EXPECT_THAT(report.warnings[0], HasSubstr(part));
  IngestOptions options;
  options.cloud = CloudDensity::kNone;
  EXPECT_THAT(ingest({PoseSource::kCameras, folder_ / "capture/cameras.json"}, options).warnings,
              Each(Not(HasSubstr("not used"))));
  expect_posed(0);
}

// Bug put back: cameras that are not wanted must have a pose; seen to fail.
TEST_F(CalibratedRig, OnlyTheCamerasThatAreTakenNeedAPose) {
  write_images();
  WrittenModel two = model("cam{:02}.png");
  two.images.pop_back();
  write_colmap_bin(folder_ / "capture/sparse_", two);
  IngestOptions options;
  options.cameras = {"cam01", "cam02"};
  const IngestReport report = ingest({}, options);
  EXPECT_EQ(report.cameras, 2);
  EXPECT_THAT(report.notes, Contains("poses of 2 cameras from sparse_ (COLMAP model)"));
  expect_input_error([&] { ingest(); }, {"false"});
  EXPECT_EQ(ingest({PoseSource::kCameras, folder_ / "capture/sparse_"}).cameras,
            2);  // named: without the third
}

}  // namespace
}  // namespace tessera
