// COLMAP models as .bin and .txt: their contents, the files that are refused, and two real models.
#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/colmap/colmap_model.h"
#include "ingest/poses/pose_matrix.h"
#include "tests/ingest/colmap/colmap_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

void expect_same_model(const ColmapModel& one, const ColmapModel& other, double tolerance) {
  ASSERT_EQ(one.photos.size(), other.photos.size());
  for (size_t i = 0; i < one.photos.size(); ++i) {
    EXPECT_EQ(one.photos[i].name, other.photos[i].name);
    EXPECT_EQ(one.photos[i].lens_model, other.photos[i].lens_model);
    EXPECT_NEAR(one.photos[i].lens.k1, other.photos[i].lens.k1, tolerance);
    EXPECT_NEAR(one.photos[i].lens.p2, other.photos[i].lens.p2, tolerance);
    expect_same_camera(one.photos[i].camera, other.photos[i].camera, tolerance);
  }
}

/// The text file lists its points in another order: sums, which see every value.
void expect_same_points(const PointCloud& one, const PointCloud& other) {
  ASSERT_EQ(one.position.size(), other.position.size());
  glm::dvec3 position(0);
  std::array<int64_t, 3> colour{};
  for (size_t i = 0; i < one.position.size(); ++i) {
    position += glm::dvec3(one.position[i]) - glm::dvec3(other.position[i]);
    for (size_t c = 0; c < 3; ++c) colour[c] += int64_t(one.colour[i][c]) - other.colour[i][c];
  }
  EXPECT_LT(glm::length(position), 1e-6 * double(one.position.size()));
  EXPECT_EQ(colour, (std::array<int64_t, 3>{}));
}

// Bugs put back: quaternion read as x y z w; names sorted backwards; a feature taken for 20 bytes;
// each seen to fail.
TEST(ColmapModel, BinaryAndTextHoldTheSame) {
  const TemporaryFolder folder;
  const WrittenModel written = small_colmap_model(5);
  write_colmap_bin(folder / "bin/sparse/0", written);
  write_colmap_txt(folder / "txt/sparse", written);
  EXPECT_EQ(find_colmap_model(folder / "bin"), folder / "bin/sparse/0");
  EXPECT_EQ(find_colmap_model(folder / "txt"), folder / "txt/sparse");
  const ColmapModel bin = read_colmap_model(folder / "bin/sparse/0");
  const ColmapModel txt = read_colmap_model(folder / "txt/sparse");
  expect_same_model(bin, txt, 1e-15);
  EXPECT_TRUE(bin.warnings.empty() && txt.warnings.empty());
  ASSERT_EQ(bin.photos.size(), 5u);
  for (const ColmapPhoto& photo : bin.photos)  // tracks name the first and the third of the file
    EXPECT_EQ(photo.error.value_or(-1),
              photo.name == "b04.png" || photo.name == "b02.png" ? 0.5 : -1)
        << photo.name;
  for (int i = 0; i < 5; ++i) {
    const ColmapPhoto& photo = bin.photos[size_t(i)];
    EXPECT_EQ(photo.name, fmt::format("b{:02}.png", i));
    EXPECT_TRUE(photo.lens.is_pinhole());
    EXPECT_EQ(photo.camera.width, 32);
    const Stand stand = looking_at_origin({5 * std::cos(0.3 * i), 5 * std::sin(0.3 * i), 1});
    EXPECT_LT(glm::distance(photo.camera.position(), stand.centre), 1e-12);
    EXPECT_LT(glm::distance(project(photo.camera, glm::dvec3(0)), {16.5, 11.5}), 1e-12);
    const glm::dvec2 above = project(photo.camera, 0.1 * stand.up);
    EXPECT_NEAR(above.x, 16.5, 1e-12);
    EXPECT_NEAR(above.y, 11.5 - 42 * 0.1 / std::sqrt(26.0), 1e-12);
  }
  for (const PointCloud& points : {bin.points, txt.points}) {
    ASSERT_EQ(points.position.size(), 3u);
    EXPECT_EQ(points.position[1], glm::vec3(-0.125, 0.5, 2.25));
    EXPECT_EQ(points.colour[1], (std::array<uint8_t, 3>{255, 0, 128}));
  }
}

// Bugs put back: need() that checks nothing; skip_list() without its check; expect_end()
// not called; each seen to fail.
TEST(ColmapModel, EveryTruncationOfABinaryFileIsRefused) {
  const TemporaryFolder folder;
  write_colmap_bin(folder.path(), small_colmap_model(3));
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string bytes = read_bytes(folder / name);
    for (size_t size = 0; size < bytes.size(); ++size) {
      write_bytes(folder / name, bytes.substr(0, size));
      expect_input_error([&] { read_colmap_model(folder.path()); },
                         {name, "truncated", "copy the model again"});
    }
    write_bytes(folder / name, bytes + "x");
    expect_input_error([&] { read_colmap_model(folder.path()); }, {name, "has 1 bytes after its"});
    write_bytes(folder / name, std::string(7, '\xff') + bytes.substr(7));
    expect_input_error([&] { read_colmap_model(folder.path()); }, {name, "truncated"});
    write_bytes(folder / name, bytes);
  }
}

// Bug put back: a word's unread end ignored ("4x" is 4); seen to fail.
TEST(ColmapModel, DamagedTextNamesTheLine) {
  const TemporaryFolder folder;
  write_colmap_txt(folder.path(), small_colmap_model(2));
  const auto expect = [&](const char* name, const std::string& text,
                          const std::vector<std::string>& parts) {
    const std::string before = read_bytes(folder / name);
    write_bytes(folder / name, text);
    expect_input_error([&] { read_colmap_model(folder.path()); }, parts);
    write_bytes(folder / name, before);
  };
  expect("cameras.txt", "#\n1 PINHOLE 32 24 40 42 16\n",
         {"cameras.txt, line 2", "has 3 parameters, PINHOLE has 4 (fx fy cx cy)"});
  expect("cameras.txt", "1 PINHOLE 32 24 40 42 16 4x\n", {"line 1", "'4x'", "expected a number"});
  expect("cameras.txt", "1 PINHOLE 32\n", {"ends before the height"});
  expect("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n1 2\n", {"images.txt, line 2", "has 2 values"});
  expect("images.txt", "1 1 0 0 0 0 0 0 1\n\n", {"ends before the image's name"});
  expect("points3D.txt", "1 0 0 0 256 0 0 1\n", {"points3D.txt, line 1", "'256'", "colour"});
  expect("points3D.txt", "1 0 0 0 25 0 0 1 5\n", {"track of an odd number"});
}

TEST(ColmapModel, TextOfOtherHandsIsRead) {
  const TemporaryFolder folder;
  write_colmap_txt(folder.path(), small_colmap_model(2));
  write_bytes(folder / "images.txt",
              "# Number of images: 3, mean observations per image: 0\r\n\r\n"
              "1 1 0 0 0 0 0 0 1 left side/a b.png \r\n\r\n  2\t1 0 0 0 0 0 1e-1 1 c.png\n\n");
  const ColmapModel model = read_colmap_model(folder.path());
  ASSERT_EQ(model.photos.size(), 2u);
  EXPECT_EQ(model.photos[1].name, "left side/a b.png");
  EXPECT_EQ(model.photos[0].camera.translation.z, 0.1);
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("states 3 records in its comment, holds 2"), std::string::npos);
}

// Bugs put back, each seen to fail: names compared with their case; a list of cameras without one
// of images taken for a model.
TEST(ColmapModel, IsFoundAsOtherProgramsWriteIt) {
  const TemporaryFolder folder;
  write_colmap_txt(folder / "capitals/sparse/0", small_colmap_model(2));
  const auto in_capitals = folder / "capitals/sparse/0";
  std::filesystem::rename(in_capitals / "cameras.txt", in_capitals / "Cameras.txt");
  std::filesystem::rename(in_capitals / "images.txt", in_capitals / "Images.txt");
  std::filesystem::rename(in_capitals / "points3D.txt", in_capitals / "Points3D.txt");
  EXPECT_EQ(find_colmap_model(folder / "capitals"), in_capitals);
  const ColmapModel model = read_colmap_model(in_capitals);
  EXPECT_EQ(model.photos.size(), 2u);
  EXPECT_EQ(model.points.position.size(), 3u);
  write_colmap_txt(folder / "flat", small_colmap_model(2));
  EXPECT_TRUE(find_colmap_model(folder / "flat").empty()) << "no images";
  write_bytes(folder / "flat/b00.png", "");
  EXPECT_EQ(find_colmap_model(folder / "flat"), folder / "flat");
  std::filesystem::remove(folder / "flat/images.txt");
  EXPECT_TRUE(find_colmap_model(folder / "flat").empty());
}

// Bugs put back, each seen to fail: the line of observations required at the end, and behind each
// image; observations with many numbers taken for an image.
TEST(ColmapModel, LinesOfObservationsMayBeMissing) {
  const TemporaryFolder folder;
  write_colmap_txt(folder.path(), small_colmap_model(2));
  const auto names = [&](const std::string& images) {
    write_bytes(folder / "images.txt", images);
    std::string all;
    for (const ColmapPhoto& photo : read_colmap_model(folder.path()).photos)
      all += photo.name + ";";
    return all;
  };
  EXPECT_EQ(names("1 1 0 0 0 0 0 0 1 a.png"), "a.png;");
  EXPECT_EQ(names("1 1 0 0 0 0 0 0 1 IMG 1 a.png\n2 1 0 0 0 0 0 0 1 IMG 2 b.png\n"),
            "IMG 1 a.png;IMG 2 b.png;");
  EXPECT_EQ(names("1 1 0 0 0 0 0 0 1 a.png\n# the next\n2 1 0 0 0 0 0 0 1 7 b.png\n\n"
                  "3 1 0 0 0 0 0 0 1 c.png\n12 1 0 7 2e-1 1 8 9 1 10 11 12\n"
                  "4 1 0 0 0 0 0 0 1 0004.png\n"),
            "0004.png;7 b.png;a.png;c.png;");
}

// Bugs put back, each seen to fail: a camera that no image uses stops everything; images of a
// camera that cannot be used are kept; they are left out without a word.
TEST(ColmapModel, ACameraThatCannotBeUsedTakesItsImagesOut) {
  for (const char* kind : {"bin", "txt"}) {
    const TemporaryFolder folder;
    WrittenModel model = small_colmap_model(3);
    const auto read = [&] {
      if (kind == std::string("bin"))
        write_colmap_bin(folder.path(), model);
      else
        write_colmap_txt(folder.path(), model);
      return read_colmap_model(folder.path());
    };
    model.cameras.push_back(model.cameras[0]);
    model.cameras[1].id = 7;
    model.cameras[1].parameters[0] = std::numeric_limits<double>::quiet_NaN();
    ColmapModel all = read();
    EXPECT_EQ(all.photos.size(), 3u);
    EXPECT_TRUE(all.warnings.empty());
    model.images[1].camera = 7;
    all = read();
    ASSERT_EQ(all.photos.size(), 2u);
    EXPECT_EQ(all.photos[1].name, "b02.png");
    ASSERT_EQ(all.warnings.size(), 1u);
    for (const char* part : {"fx of PINHOLE is nan", "1 of 3 images is of this camera", "b01.png"})
      EXPECT_NE(all.warnings[0].find(part), std::string::npos) << all.warnings[0];
  }
}

// Bug put back: the look-up of an image's camera not checked; seen to fail.
TEST(ColmapModel, WhatCannotBeIsRefused) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::function<void(WrittenModel&)>& spoil,
                          const std::vector<std::string>& parts) {
    WrittenModel model = small_colmap_model(3);
    spoil(model);
    write_colmap_bin(folder / "bin", model);
    write_colmap_txt(folder / "txt", model);
    for (const char* kind : {"bin", "txt"})
      expect_input_error([&] { read_colmap_model(folder / kind); }, parts);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect([](auto& m) { m.images[1].camera = 8; }, {"b01.png is of camera 8", "images."});
  expect([](auto& m) { m.images[1].name = "b00.png"; }, {"'b00.png' twice"});
  expect([](auto& m) { m.images[1].quaternion = {}; }, {"b01.png", "quaternion of length 0"});
  expect([](auto& m) { m.images[1].translation.y = kNan; }, {"b01.png", "nan"});
  expect([](auto& m) { m.images.clear(); }, {"holds no images"});
  expect([](auto& m) { m.cameras.push_back({}); }, {"cameras.", "camera 1 twice"});
  expect([](auto& m) { m.cameras[0].width = 0; }, {"cameras.", "0x24 pixels"});
  expect([](auto& m) { m.cameras[0].parameters[1] = -4; }, {"fy of PINHOLE is -4"});
  expect([](auto& m) { m.cameras[0].parameters[2] = kNan; }, {"cx of PINHOLE is nan"});
  expect(
      [](auto& m) {
        m.cameras[0].model = "EQUIRECT";
        m.cameras[0].number = 11;
      },
      {"camera model", "is unknown", "10 THIN_PRISM_FISHEYE", "image_undistorter"});
}

TEST(ColmapModel, MissingFilesAndPointsThatAreNotFinite) {
  const TemporaryFolder folder;
  WrittenModel model = small_colmap_model(3);
  model.points[0].position.z = std::numeric_limits<double>::infinity();
  write_colmap_bin(folder.path(), model);
  const ColmapModel read = read_colmap_model(folder.path());
  EXPECT_EQ(read.points.position.size(), 2u);
  EXPECT_EQ(read.points.colour[0], (std::array<uint8_t, 3>{255, 0, 128}));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("1 of 3 points"), std::string::npos);
  std::filesystem::remove(folder / "points3D.bin");
  EXPECT_EQ(read_colmap_model(folder.path()).warnings.size(), 1u);
  std::filesystem::remove(folder / "images.bin");
  expect_input_error([&] { read_colmap_model(folder.path()); }, {"images.bin", "no such file"});
}

// Bug put back: RADIAL with the number 10; seen to fail.
TEST(ColmapModel, AllModelsOfColmapAreRead) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, size_t>> models{{"SIMPLE_PINHOLE", 3},
                                                           {"PINHOLE", 4},
                                                           {"SIMPLE_RADIAL", 4},
                                                           {"RADIAL", 5},
                                                           {"OPENCV", 8},
                                                           {"OPENCV_FISHEYE", 8},
                                                           {"FULL_OPENCV", 12},
                                                           {"FOV", 5},
                                                           {"SIMPLE_RADIAL_FISHEYE", 4},
                                                           {"RADIAL_FISHEYE", 5},
                                                           {"THIN_PRISM_FISHEYE", 12}};
  for (size_t number = 0; number < models.size(); ++number) {
    const auto& [name, count] = models[number];
    WrittenModel model = small_colmap_model(1);
    std::vector<double> parameters(count, 0.01);
    const bool one_focal = name.starts_with("SIMPLE") || name.starts_with("RADIAL");
    parameters[0] = parameters[one_focal ? 0 : 1] = 50;
    parameters.back() = 0.02;
    model.cameras[0] = {1, int32_t(number), name, 32, 24, parameters};
    write_colmap_bin(folder / "bin", model);
    write_colmap_txt(folder / "txt", model);
    const ColmapModel bin = read_colmap_model(folder / "bin");
    expect_same_model(bin, read_colmap_model(folder / "txt"), 0);
    EXPECT_EQ(bin.photos[0].lens_model, name);
    EXPECT_EQ(bin.photos[0].camera.fl_y, 50) << name;
    EXPECT_EQ(bin.photos[0].camera.cx, 0.01) << name;
    EXPECT_EQ(bin.photos[0].lens.is_pinhole(), number < 2) << name;
    EXPECT_EQ(bin.photos[0].lens.projection == Lens::Projection::kFisheye,
              name.find("FISHEYE") != std::string::npos)
        << name;
  }
}

TEST(RealColmapModel, BonsaiIsWhole) {
  TESSERA_NEED_DATA(folder, "bonsai");
  const ColmapModel model = read_colmap_model(find_colmap_model(folder));
  ASSERT_EQ(model.photos.size(), 292u);
  EXPECT_GT(model.points.position.size(), 10000u);
  EXPECT_TRUE(model.warnings.empty());
  size_t in_front = 0;  // of the first camera: most of what it helped to make
  for (const ColmapPhoto& photo : model.photos) {
    EXPECT_EQ(photo.camera.width, 800);
    EXPECT_TRUE(photo.lens.is_pinhole());
  }
  const Camera& first = model.photos[0].camera;
  for (const glm::vec3& point : model.points.position)
    in_front += (first.cam_from_world * glm::dvec3(point) + first.translation).z > 0;
  EXPECT_GT(in_front, model.points.position.size() / 2);
}

TEST(RealColmapModel, RoomIsTheSameInItsThreeForms) {
  TESSERA_NEED_DATA(folder, "colmap_room");
  const ColmapModel bin = read_colmap_model(find_colmap_model(folder));
  const ColmapModel txt = read_colmap_model(folder / "sparse_text");
  EXPECT_TRUE(txt.warnings.empty());
  EXPECT_EQ(bin.points.position.size(), 5740u);
  expect_same_model(bin, txt, 1e-13);  // text has 17 digits
  expect_same_points(bin.points, txt.points);
  EXPECT_EQ(bin.photos[0].lens_model, "OPENCV");
  // The JSON's world is another one, by a similarity: turns and ratios of distances agree.
  const json file = json::parse(read_bytes(folder / "transforms.json"));
  std::map<std::string, Camera> stated;
  for (const json& frame : file["frames"]) {
    PoseRows rows{};
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) rows[r][c] = frame["transform_matrix"][r][c];
    const std::string path = frame["file_path"];
    set_pose(stated[path.substr(path.rfind('/') + 1)], rows, path);
  }
  ASSERT_EQ(bin.photos.size(), stated.size());
  const Camera& one = bin.photos[0].camera;
  const Camera& other = stated.at(bin.photos[0].name);
  const auto apart = [](const Camera& a, const Camera& b) {
    return glm::distance(a.position(), b.position());
  };
  const double scale =
      apart(stated.at(bin.photos.back().name), other) / apart(bin.photos.back().camera, one);
  for (const ColmapPhoto& photo : bin.photos) {
    const Camera& expected_camera = stated.at(photo.name);
    const glm::dmat3 turn = photo.camera.cam_from_world * glm::transpose(one.cam_from_world);
    const glm::dmat3 expected =
        expected_camera.cam_from_world * glm::transpose(other.cam_from_world);
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::distance(turn[c], expected[c]), 1e-9) << photo.name;
    EXPECT_NEAR(apart(expected_camera, other), scale * apart(photo.camera, one), 1e-6 * scale)
        << photo.name;
  }
}

}  // namespace
}  // namespace tessera
