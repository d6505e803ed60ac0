// Photo sets with a COLMAP model are converted to a prepared scene, undistorted, and loaded as a
// Scene.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/images/image_source.h"
#include "ingest/images/resampling.h"
#include "ingest/ingest.h"
#include "tests/ingest/colmap/colmap_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

class ColmapCapture : public ::testing::Test {
 protected:
  void write(int photos) {
    model_ = small_colmap_model(photos);
    write_photo_set(capture_, model_);
  }
  /// In the model's world.
  IngestReport ingest(IngestOptions options = {}) {
    options.keep_world = true;
    return ingest_capture(capture_, folder_ / "scene", options, {});
  }
  Scene scene() { return load_scene(folder_ / "scene", {}); }
  void expect_refused(const IngestOptions& options, const std::vector<std::string>& parts) {
    expect_input_error([&] { ingest(options); }, parts);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "scene"));
  }

  TemporaryFolder folder_;
  std::filesystem::path capture_ = folder_ / "capture";
  WrittenModel model_;
};

// Bugs put back: names sorted backwards; is_static not set; points.ply without the colours; each
// seen to fail.
TEST_F(ColmapCapture, BecomesAStaticScene) {
  write(18);
  ingest();
  const Scene scene = this->scene();  // no allow_static needed
  EXPECT_TRUE(scene.is_static);
  ASSERT_EQ(scene.frames.size(), 18u);
  for (int i = 0; i < 18; ++i) {
    const Frame& frame = scene.frames[size_t(i)];
    EXPECT_EQ(frame.name, fmt::format("images/b{:02}", i));
    EXPECT_EQ(frame.camera_name, fmt::format("b{:02}", i));
    EXPECT_EQ(frame.split, i % 8 == 0 ? Split::kTest : Split::kTrain);
    EXPECT_EQ(frame.time, 0);
    EXPECT_EQ(frame.image.data, read_png(capture_ / "images" / (frame.camera_name + ".png")).data);
    EXPECT_LT(glm::distance(project(frame.camera, glm::dvec3(0)), {16.5, 11.5}), 1e-9);
    EXPECT_NEAR(glm::length(frame.camera.position()), std::sqrt(26.0), 1e-9);
  }
  EXPECT_EQ(scene.points.position[1], glm::vec3(-0.125, 0.5, 2.25));
  EXPECT_EQ(scene.points.colour[1], (std::array<uint8_t, 3>{255, 0, 128}));
  const json file = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(file["tessera"]["applied"]["undistortion"], "none");
  EXPECT_EQ(file["tessera"]["source_hashes_fnv1a64"].size(), 18u + 3u);
  EXPECT_TRUE(file["tessera"]["source_hashes_fnv1a64"].contains("sparse/0/images.bin"));
}

TEST_F(ColmapCapture, WithoutPhotosItIsRefused) {
  write(3);
  std::filesystem::rename(capture_ / "images", capture_ / "photos");
  EXPECT_EQ(ingest().frames, 3) << "the only folder with images";
  std::filesystem::remove_all(folder_ / "scene");
  std::filesystem::create_directories(capture_ / "images");
  expect_refused({}, {"none of the 3 photos", "b00.png, b01.png, b02.png", "--images"});
  IngestOptions options;
  options.images = "photos";
  EXPECT_EQ(ingest(options).frames, 3);
}

// Bugs put back: the intrinsics of the model's size kept; any shape accepted; each seen to fail.
TEST_F(ColmapCapture, ReducedPhotosHaveTheSameRays) {
  write(3);
  std::filesystem::remove_all(capture_ / "images");
  for (const char* folder : {"images_2", "images_4"}) {
    const int by = folder[7] - '0';
    std::filesystem::create_directories(capture_ / folder);
    for (int i = 0; i < 3; ++i)
      write_png(capture_ / folder / fmt::format("b{:02}.png", i),
                patterned_image(32 / by, 24 / by, 3, i));
    if (by == 2) {  // the only folder there is
      EXPECT_EQ(ingest().frames, 3);
    }
  }
  EXPECT_EQ(scene().frames[0].camera.fl_x, 20);
  EXPECT_EQ(scene().frames[0].camera.cy, 5.75);
  expect_input_error([&] { ingest(); }, {"pass --images with one of images_2, images_4"});
  IngestOptions options;
  options.images = "images_4";
  options.scale = 0.5;
  ingest(options);
  EXPECT_EQ(scene().frames[0].camera.fl_y, 42 / 8.0);
  EXPECT_EQ(scene().frames[0].image.width, 4);
  write_png(capture_ / "images_4/b01.png", patterned_image(6, 8, 3));  // turned
  expect_input_error([&] { ingest(options); }, {"b01.png: is 6x8", "made for 32x24"});
}

TEST_F(ColmapCapture, OnePhotoAloneIsNotHeldOut) {
  write(2);
  std::filesystem::remove(capture_ / "images/b01.png");
  ingest();
  EXPECT_TRUE(scene().split_indices(Split::kTest).empty());
}

// Bug put back: the videos before the model; seen to fail.
TEST_F(ColmapCapture, LayoutIsFoundBesideOtherFiles) {
  write(2);
  EXPECT_EQ(detect_layout(capture_), CaptureLayout::kColmap);
  write_bytes(capture_ / "a.mp4", "");
  EXPECT_EQ(detect_layout(capture_), CaptureLayout::kColmap);  // the video the photos are from
  write_bytes(capture_ / "poses_bounds.npy", "");
  EXPECT_EQ(detect_layout(capture_), CaptureLayout::kN3dv);
  write_bytes(capture_ / "transforms.json", "{}");
  EXPECT_EQ(detect_layout(capture_), CaptureLayout::kTransforms);
}

/// The ramp, undistorted, shows at each pixel where COLMAP's camera has that pixel's ray.
void expect_ramp(const Frame& frame, const std::function<glm::dvec2(glm::dvec2)>& pixel_of_ray) {
  const Camera& camera = frame.camera;
  double worst = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const uint8_t* rgb = frame.image.data.data() + 3 * (y * camera.width + x);
      const glm::dvec2 expected =
          pixel_of_ray({(x + 0.5 - camera.cx) / camera.fl_x, (y + 0.5 - camera.cy) / camera.fl_y});
      ASSERT_EQ(rgb[2], 7);
      if (std::min(expected.x, expected.y) < 0.5 || expected.x > 199.5 || expected.y > 159.5)
        continue;  // the image's border repeats for half a pixel
      worst = std::max(
          {worst, std::abs(rgb[0] + 0.5 - expected.x), std::abs(rgb[1] + 0.5 - expected.y)});
    }
  EXPECT_LT(worst, 0.5 + 1 / 32.0);  // rounding to 8 bit, and OpenCV's steps of 1/32 pixel
  EXPECT_GT(worst, 0.1);
}

// Bugs put back: half a pixel of shift (OpenCV's centres); the lens left out; the focal lengths of
// the image for those of the pinhole camera; "undistortion" not noted; each seen to fail.
TEST_F(ColmapCapture, DistortedPhotosBecomePinhole) {
  model_ = small_colmap_model(2);
  model_.cameras[0] = {1, 2, "SIMPLE_RADIAL", 200, 160, {150, 98, 83, 0.15}};
  model_.cameras.push_back({4, 5, "OPENCV_FISHEYE", 200, 160, {90, 95, 98, 83, 0.01, 0, 0, 0}});
  model_.images[0].camera = 4;  // b01
  write_photo_set(capture_, model_);
  for (const char* name : {"b00.png", "b01.png"})
    write_png(capture_ / "images" / name, ramp(200, 160));
  ingest();
  const Scene scene = this->scene();
  expect_ramp(scene.frames[0], [](glm::dvec2 ray) {
    return glm::dvec2(98, 83) + 150.0 * ray * (1 + 0.15 * glm::dot(ray, ray));
  });
  EXPECT_GT(scene.frames[0].camera.fl_x, 150 * 1.02);  // no blank pixels
  expect_ramp(scene.frames[1], [](glm::dvec2 ray) {
    const double r = glm::length(ray), theta = std::atan(r);
    return glm::dvec2(98, 83) + glm::dvec2(90, 95) * ray * (theta * (1 + 0.01 * theta * theta) / r);
  });
  const json file = json::parse(read_bytes(folder_ / "scene/transforms.json"));
  EXPECT_EQ(file["tessera"]["applied"]["undistortion"], "OPENCV_FISHEYE, SIMPLE_RADIAL");
}

// Bugs put back: colours not multiplied by alpha; nor divided by it again; each seen to fail.
TEST(Undistortion, TransparentColoursDoNotBleed) {
  Image8 image = constant_image(40, 30, {200, 100, 50, 255});
  for (size_t p = 0; p < image.data.size(); p += 4)
    if ((p / 4) % 40 >= 20) {
      image.data[p] = 50;
      image.data[p + 3] = 0;
    }
  const Camera camera{40, 30, 30, 30, 20, 15, 0, glm::dmat3(1), glm::dvec3(0)};
  Lens lens;
  lens.k1 = -0.1;
  lens.p2 = 0.05;
  const Image8 result = Undistortion(camera, lens, camera).apply(image);
  size_t partial = 0;
  for (size_t p = 0; p < result.data.size(); p += 4) {
    partial += result.data[p + 3] > 0 && result.data[p + 3] < 255;
    if (result.data[p + 3] > 20) {  // below that, rounding is coarse
      EXPECT_NEAR(result.data[p], 200, 3);
    }
  }
  EXPECT_GT(partial, 5u);
}

// The whole set takes longer: two JPEGs of it, and the room's distorted ones.
TEST(RealPhotoSets, JpegsAreKeptAndOpenCvModelsUndistorted) {
  for (const char* name : {"bonsai", "colmap_room"}) {
    TESSERA_NEED_DATA(data, name);
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder / "capture/images");
    std::filesystem::create_directory_symlink(data / "sparse", folder / "capture/sparse");
    const bool is_bonsai = name == std::string("bonsai");
    const std::vector<std::string> photos =
        is_bonsai ? std::vector<std::string>{"DSCF5565.JPG", "DSCF5567.JPG"}
                  : std::vector<std::string>{"0001.jpg", "0002.jpg"};
    for (const std::string& photo : photos)
      std::filesystem::create_symlink(data / "images" / photo,
                                      folder / ("capture/images/" + photo));
    const IngestReport report = ingest_capture(folder / "capture", folder / "scene", {}, {});
    EXPECT_EQ(report.frames, 2);
    EXPECT_EQ(report.warnings.size(), 1u);
    const Scene scene = load_scene(folder / "scene", {});
    EXPECT_EQ(int64_t(scene.points.position.size()), report.points);
    EXPECT_EQ(scene.split_indices(Split::kTest), (std::vector<int>{0}));
    const Image8 source = read_image(data / "images" / photos[1]);
    EXPECT_EQ(scene.frames[1].image.data == source.data, is_bonsai);
    EXPECT_EQ(scene.frames[1].image.data.size(), source.data.size());
    EXPECT_NEAR(scene.frames[1].camera.fl_x, is_bonsai ? 826.70 : 903.31, 0.01);
  }
}

}  // namespace
}  // namespace tessera
