// Every form of calibration by its file and by its folder, and files that are none.
#include "ingest/calibration/calibration.h"

#include <nlohmann/json.hpp>

#include "ingest/calibration/stated_cameras.h"
#include "ingest/poses/llff_poses.h"
#include "tests/ingest/colmap/colmap_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;
using std::filesystem::path;

constexpr const char* kIntri = R"(%YAML:1.0
---
names:
   - "01"
   - "02"
K_01: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 100., 0., 60., 0., 110., 40., 0., 0., 1. ]
dist_01: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0.1, 0., 0., 0., 0. ]
K_02: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 200., 0., 60., 0., 210., 40., 0., 0., 1. ]
)";
constexpr const char* kExtri = R"(%YAML:1.0
---
names:
   - "01"
   - "02"
R_01: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 0., 0., -1.5707963267948966 ]
T_01: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 1., 2., 3. ]
Rot_02: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T_02: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 4., 5., 6. ]
)";
constexpr const char* kXml = R"(<?xml version="1.0"?>
<opencv_storage>
<image_width>120</image_width>
<image_height>80</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>100. 0. 60. 0. 110. 40. 0. 0. 1.</data></camera_matrix>
<R type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>1. 0. 0. 0. 1. 0. 0. 0. 1.</data></R>
<T type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt><data>7. 8. 9.</data></T>
</opencv_storage>
)";

std::vector<std::string> names_in(const Calibration& calibration) {
  std::vector<std::string> names;
  for (const RigCamera& camera : calibration.cameras) names.push_back(camera.name);
  return names;
}

// Bug put back: a file of a model not known by its name; seen to fail.
TEST(Calibration, ColmapModelsByFolderFileAndParent) {
  const TemporaryFolder folder;
  const WrittenModel model = small_colmap_model(3);
  write_colmap_bin(folder / "bin/sparse/0", model);
  write_colmap_txt(folder / "txt/sparse_", model);
  for (const char* place : {"bin/sparse/0", "bin/sparse", "bin", "bin/sparse/0/images.bin",
                            "txt/sparse_", "txt", "txt/sparse_/points3D.txt"}) {
    SCOPED_TRACE(place);
    const Calibration read = read_calibration(folder / place);
    EXPECT_EQ(read.form, "COLMAP model");
    EXPECT_EQ(names_in(read), (std::vector<std::string>{"b00.png", "b01.png", "b02.png"}));
    EXPECT_EQ(read.points.position.size(), 3u);
    EXPECT_EQ(read.files.size(), 3u);
    EXPECT_EQ(read.cameras[0].camera.fl_y, 42);
    EXPECT_NEAR(read.cameras[0].camera.position().x, 5, 1e-9);
  }
}

// Bug put back: only intri.yml known by its name; seen to fail.
TEST(Calibration, EasyMocapByFolderAndByEitherFile) {
  const TemporaryFolder folder;
  write_bytes(folder / "intri.yml", kIntri);
  write_bytes(folder / "extri.yml", kExtri);
  for (const path& place : {folder.path(), folder / "intri.yml", folder / "extri.yml"}) {
    const Calibration read = read_calibration(place);
    ASSERT_EQ(names_in(read), (std::vector<std::string>{"01", "02"}));
    EXPECT_EQ(read.cameras[0].lens.k1, 0.1);
    EXPECT_EQ(read.cameras[1].camera.fl_y, 210);
    EXPECT_EQ(read.cameras[1].camera.translation, glm::dvec3(4, 5, 6));
    EXPECT_NEAR(read.cameras[0].camera.cam_from_world[1][0], 1, 1e-9);
    EXPECT_EQ(read.cameras[0].camera.width, 0);
  }
  std::filesystem::remove(folder / "intri.yml");
  expect_input_error([&] { read_calibration(folder / "extri.yml"); },
                     {"extri.yml", "belong together"});
}

// Bug put back: the camera called as its file with the extension; seen to fail.
TEST(Calibration, OneFileACamera) {
  const TemporaryFolder folder;
  const json camera = {
      {"K", {100, 0, 60, 0, 110, 40, 0, 0, 1}}, {"rvec", {0, 0, 0}}, {"tvec", {1, 2, 3}}};
  write_bytes(folder / "left.json", camera.dump());
  write_bytes(folder / "right.xml", kXml);
  const Calibration read = read_calibration(folder.path());
  ASSERT_EQ(names_in(read), (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(read.cameras[0].camera.translation, glm::dvec3(1, 2, 3));
  EXPECT_EQ(read.cameras[1].camera.translation, glm::dvec3(7, 8, 9));
  EXPECT_EQ(read.cameras[1].camera.width, 120);
  EXPECT_EQ(read.files.size(), 2u);
  write_bytes(folder / "middle.yml", "%YAML:1.0\n---\nT: [1, 2, 3]\nrvec: [0, 0, 0]\n");
  expect_input_error([&] { read_calibration(folder.path()); },
                     {"middle.yml", "camera middle", "add K"});
  write_bytes(folder / "middle.yml", "%YAML:1.0\n---\nK: [.Nan, 0, 1, 0, 1, 1, 0, 0, 1]\n");
  expect_input_error([&] { read_calibration(folder.path()); }, {"middle.yml", "K is not 9 finite"});
}

TEST(Calibration, LlffRowsGoByTheOrderOfNames) {
  const TemporaryFolder folder;
  LlffPose first, second;
  first.camera = {64, 48, 50, 50, 32, 24, 0, glm::dmat3(1), {0, 0, 1}};
  second.camera = first.camera;
  second.camera.translation = {1, 2, 3};
  write_llff_poses(folder / "p.npy", {first, second});
  std::vector<std::string> warnings;
  const auto stated = stated_cameras(folder.path(), {PoseSource::kCameras, folder / "p.npy"},
                                     {"x", "y"}, {}, warnings);
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->cameras[1]->name, "y");
  expect_same_camera(stated->cameras[1]->camera, second.camera, 1e-12);
  EXPECT_TRUE(warnings.empty());
  stated_cameras(folder.path(), {PoseSource::kCameras, folder / "p.npy"}, {"cam10", "cam9"}, {},
                 warnings);
  ASSERT_EQ(warnings.size(), 1u) << "16.4 dB for 23.0 where the rows count";
  EXPECT_NE(warnings[0].find("in the order of letters, cam10, cam9"), std::string::npos);
}

// A camera of the calibration that has no clip may be one that was not found. Bugs put back, each
// seen to fail: nothing is said; further images of a camera that has a clip count.
TEST(Calibration, CamerasWithoutClipAreNamed) {
  const TemporaryFolder folder;
  json file = {{"fl_x", 50}, {"w", 64}, {"h", 48}, {"cameras", json::array()}};
  for (const char* name : {"a", "b/0000.png", "b/0001.png", "c"})
    file["cameras"].push_back(
        {{"name", name},
         {"transform_matrix",
          {{1, 0, 0, int(name[0] == 'b')}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}});
  write_bytes(folder / "cal.json", file.dump());
  const auto said = [&](const std::vector<std::string>& clips) {
    std::vector<std::string> warnings;
    stated_cameras(folder.path(), {PoseSource::kCameras, folder / "cal.json"}, clips, {}, warnings);
    return warnings;
  };
  EXPECT_TRUE(said({"a", "b", "c"}).empty());
  ASSERT_EQ(said({"a", "b"}).size(), 1u);
  EXPECT_NE(said({"a", "b"})[0].find("has no clip of c; it has a, b"), std::string::npos);
}

// Bug put back: an exception of OpenCV not caught; seen to fail.
TEST(Calibration, WhatIsNoneNamesTheFileAndTheForms) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& bytes,
                           const std::vector<std::string>& parts) {
    write_bytes(folder / name, bytes);
    expect_input_error([&] { read_calibration(folder / name); }, parts);
  };
  refused("cameras.csv", "#name,x,y\n", {"cameras.csv", "COLMAP model", "intri.yml", ".npy"});
  refused("agisoft.xml", "<?xml version=\"1.0\"?>\n<document><chunk/></document>\n",
          {"agisoft.xml", "cv::FileStorage"});
  refused("cut.yml", std::string(kIntri).substr(0, 120), {"cut.yml"});
  refused("plain.yml", "K: 3\n", {"plain.yml", "cv::FileStorage"});
  refused("none.json", "{\"a\": 1}", {"none.json", "no camera (K, R, T)"});
  refused("bad.json", "{", {"bad.json", "JSON"});
  std::filesystem::create_directories(folder / "empty");
  expect_input_error([&] { read_calibration(folder / "empty"); },
                     {"empty", "holds no calibration", "poses_bounds.npy"});
  expect_input_error([&] { read_calibration(folder / "absent"); }, {"absent", "no such file"});
}

TEST(Calibration, RealRigs) {
  TESSERA_NEED_DATA(studio, "studio");
  std::vector<std::string> names, warnings;
  for (int i = 0; i < 11; ++i) names.push_back(i < 10 ? "cam0" + std::to_string(i) : "cam10");
  const auto truth = stated_cameras(studio, {PoseSource::kCameras, studio / "ground_truth.json"},
                                    names, {}, warnings)
                         ->cameras;
  const auto rows = stated_cameras(studio, {PoseSource::kN3dv, {}}, names, {}, warnings)->cameras;
  for (size_t i = 0; i < names.size(); ++i)
    expect_same_camera(truth[i]->camera, rows[i]->camera, 1e-6);
  TESSERA_NEED_DATA(videos, "video_4cam");
  const RigCamera camera =
      *stated_cameras(videos, {PoseSource::kCameras, videos / "cameras_opencv.json"},
                      {"cam01", "cam04"}, {}, warnings)
           ->cameras[0];
  EXPECT_NEAR(camera.camera.fl_x, 1681.2448, 1e-3);
  EXPECT_NEAR(camera.lens.k2, 0.139983, 1e-9);
  // Calib.qca.txt states the centres in mm: z of cam01 is 1896.5.
  EXPECT_NEAR(camera.camera.position().z, 1.8965, 1e-3);
}

}  // namespace
}  // namespace tessera
