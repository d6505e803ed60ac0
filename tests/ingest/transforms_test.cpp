// What: poses, axes and intrinsics of transforms files; what is refused and how it says so.
// Not: pixels and times (scene_reader_test.cpp).
#include "ingest/transforms_json.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>

#include "ingest/files/npy.h"
#include "ingest/files/png.h"
#include "ingest/llff_poses.h"
#include "ingest/pose_matrix.h"
#include "tests/ingest/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

constexpr int kSide = 64;
constexpr double kFocal = 80;

/// A cube of half-side 1 around the origin: +x red, +y green, +z blue, the other faces dark, seen
/// from `stand` by rays of a pinhole whose up is the picture's up.
Image8 cube_picture(const Stand& stand) {
  Image8 image = constant_picture(kSide, kSide, {0, 0, 0});
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double u = (x + 0.5 - kSide / 2.0) / kFocal, v = (y + 0.5 - kSide / 2.0) / kFocal;
      const glm::dvec3 ray = stand.forward + stand.right * u - stand.up * v;
      double enter = 0, leave = 1e9;
      int face = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double near = (-std::copysign(1.0, ray[axis]) - stand.centre[axis]) / ray[axis];
        const double far = (std::copysign(1.0, ray[axis]) - stand.centre[axis]) / ray[axis];
        if (near > enter) enter = near, face = axis;
        leave = std::min(leave, far);
      }
      if (enter >= leave) continue;
      const bool positive = stand.centre[face] + enter * ray[face] > 0;
      image.data[size_t(3 * (y * kSide + x) + face)] = positive ? 255 : 100;
    }
  return image;
}

std::vector<Stand> cube_rig() {
  return {looking_at_origin({5, 0.5, 1}), looking_at_origin({0.5, 5, 2}),
          looking_at_origin({-4, -3, 2}), looking_at_origin({2, 1, 5})};
}

void write_cube_capture(const std::filesystem::path& folder) {
  json file{{"fl_x", kFocal}, {"w", kSide}, {"h", kSide}, {"frames", json::array()}};
  Matrix llff{0, 17, {}};
  for (const Stand& s : cube_rig()) {
    const std::string name = "r_" + std::to_string(llff.rows) + ".png";
    write_png(folder / name, cube_picture(s));
    file["frames"].push_back({{"file_path", name}, {"transform_matrix", gl_matrix(s)}});
    const double size_and_focal[3] = {kSide, kSide, kFocal};
    for (int r = 0; r < 3; ++r)  // LLFF columns: down, right, backward, centre, (H, W, f)
      for (const double v : {-s.up[r], s.right[r], -s.forward[r], s.centre[r], size_and_focal[r]})
        llff.data.push_back(v);
    llff.data.insert(llff.data.end(), {1.0, 9.0});
    ++llff.rows;
  }
  write_bytes(folder / "transforms.json", file.dump());
  write_npy(folder / "poses_bounds.npy", llff);
}

// B6. Bugs put back, each seen to fail: the y and z columns of the pose not negated (set_pose);
// LLFF's "down" column taken as up (llff_poses.cpp).
TEST(AxisConvention, CubeFacesAreWhereTheirColoursAreInBothLayouts) {
  const TemporaryFolder folder;
  write_cube_capture(folder.path());
  const Scene scene = load_scene(folder.path(), {});
  const auto llff = read_llff_poses(folder / "poses_bounds.npy");
  ASSERT_EQ(scene.frames.size(), llff.size());
  int seen = 0;
  for (size_t i = 0; i < llff.size(); ++i) {
    const Frame& frame = scene.frames[i];
    expect_same_camera(frame.camera, llff[i].camera, 1e-12);
    EXPECT_LT(glm::distance(frame.camera.position(), cube_rig()[i].centre), 1e-12);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 face(0.0);
      face[axis] = 1;
      if (cube_rig()[i].centre[axis] <= 1) continue;  // that face is turned away
      const glm::dvec2 pixel = project(frame.camera, face);
      const int x = int(pixel.x), y = int(pixel.y);
      ASSERT_TRUE(x >= 0 && x < kSide && y >= 0 && y < kSide);
      EXPECT_EQ(frame.image.data[size_t(3 * (y * kSide + x) + axis)], 255)
          << "frame " << i << " axis " << axis;
      ++seen;
    }
  }
  EXPECT_EQ(seen, 6);
}

TEST(AxisConvention, PlusXIsRightAndPlusZIsUpForACameraThatLooksAlongPlusY) {
  Camera camera{100, 80, 50, 50, 50, 40, {}, {}};
  set_pose(camera, {{{1, 0, 0, 0}, {0, 0, -1, -4}, {0, 1, 0, 0}}}, "test");
  const glm::dvec2 x = project(camera, {1, 0, 0}), z = project(camera, {0, 0, 1});
  EXPECT_NEAR(x.x, 50 + 50.0 / 4, 1e-12);
  EXPECT_NEAR(x.y, 40, 1e-12);
  EXPECT_NEAR(z.x, 50, 1e-12);
  EXPECT_NEAR(z.y, 40 - 50.0 / 4, 1e-12);
}

TEST(Pose, SmallDeviationsAreRemovedAndTheInverseGivesThePoseBack) {
  Camera camera;
  PoseRows rows{{{0.6, -0.8, 0, 1}, {0.8, 0.6, 0, 2}, {0, 0, 1, 3}}};
  rows[0][0] += 3e-5;
  set_pose(camera, rows, "test");
  const glm::dmat3 product = camera.cam_from_world * glm::transpose(camera.cam_from_world);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(product[c][r], c == r ? 1.0 : 0.0, 1e-14);
  const PoseRows back = gl_pose_of(camera);
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(back[r][c], rows[r][c], 4e-5);
}

// Bug put back: check_rotation() not called in set_pose; seen to fail for all four.
TEST(Pose, WhatIsNoRotationIsRefused) {
  const PoseRows identity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  const auto refused = [](PoseRows rows, const std::string& why) {
    expect_input_error(
        [&] {
          Camera camera;
          set_pose(camera, rows, "frame 3 (./train/r_3)");
        },
        {"frame 3 (./train/r_3)", why, "remove the frame"});
  };
  PoseRows singular = identity, mirrored = identity, scaled = identity, bent = identity;
  singular[2] = {0, 0, 0, 0};
  mirrored[2][2] = -1;
  for (size_t i = 0; i < 3; ++i) scaled[i][i] = 2;
  bent[0][1] = 0.01;
  refused(singular, "singular");
  refused(mirrored, "mirror");
  refused(scaled, "scaled");
  refused(bent, "sheared");
}

// Bug put back: the isfinite check of set_pose removed; seen to fail.
TEST(Pose, ValuesThatAreNotFiniteAreRefused) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Camera camera;
    const PoseRows rows{{{1, 0, 0, 0}, {0, 1, 0, bad}, {0, 0, 1, 0}}};
    expect_input_error([&] { set_pose(camera, rows, "frame 1"); }, {"frame 1", "not finite"});
  }
}

// B7. Bug put back: intrinsics of another size taken as they are (no `resized`); seen to fail.
TEST(Intrinsics, HalfSizePicturesHaveTheSameRays) {
  Camera full, half;
  StatedIntrinsics stated;
  stated.fl_x = 1100.25, stated.fl_y = 1090.5, stated.cx = 401, stated.cy = 297.5;
  stated.w = 800, stated.h = 600;
  set_intrinsics(full, stated, 800, 600, "test");
  set_intrinsics(half, stated, 400, 300, "test");
  EXPECT_EQ(half.width, 400);
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {800.0, 0.0}, {123.5, 456.5}, {800.0, 600.0}})
    EXPECT_LT(glm::distance(ray_through(full, x, y), ray_through(half, x / 2, y / 2)), 1e-9);
}

TEST(Intrinsics, AnotherShapeIsRefused) {
  StatedIntrinsics stated;
  stated.fl_x = 100, stated.w = 800, stated.h = 600;
  Camera camera;
  set_intrinsics(camera, stated, 399, 300, "rounded");
  expect_input_error([&] { set_intrinsics(camera, stated, 400, 400, "frame 2"); },
                     {"frame 2", "800x600", "400x400"});
}

// Bug put back: camera_angle_x of the file preferred to fl_x of the frame; seen to fail.
TEST(Intrinsics, FrameWinsOverFileWinsOverAngle) {
  StatedIntrinsics file, frame;
  file.camera_angle_x = 2 * std::atan(0.5);
  Camera camera;
  set_intrinsics(camera, frame.or_else(file), 100, 50, "angle");
  EXPECT_NEAR(camera.fl_x, 100, 1e-12);
  EXPECT_NEAR(camera.fl_y, 100, 1e-12);
  EXPECT_EQ(camera.cx, 50);
  EXPECT_EQ(camera.cy, 25);
  file.fl_x = 200, file.cx = 51;
  set_intrinsics(camera, frame.or_else(file), 100, 50, "file");
  EXPECT_EQ(camera.fl_x, 200);
  EXPECT_EQ(camera.cx, 51);
  frame.fl_x = 300, frame.fl_y = 310;
  set_intrinsics(camera, frame.or_else(file), 100, 50, "frame");
  EXPECT_EQ(camera.fl_x, 300);
  EXPECT_EQ(camera.fl_y, 310);
  EXPECT_EQ(camera.cx, 51);
}

TEST(Intrinsics, NoneOrNonsenseIsRefused) {
  Camera camera;
  StatedIntrinsics stated;
  expect_input_error([&] { set_intrinsics(camera, stated, 4, 4, "f"); }, {"no focal length"});
  stated.fl_x = -1;
  expect_input_error([&] { set_intrinsics(camera, stated, 4, 4, "f"); }, {"fl_x", "-1"});
  stated.fl_x.reset();
  stated.camera_angle_x = 4;
  expect_input_error([&] { set_intrinsics(camera, stated, 4, 4, "f"); }, {"angle", "4"});
}

// Bug put back: refuse_distortion() not called for the file; seen to fail.
TEST(Transforms, DistortionIsRefusedAndZeroDistortionIsNot) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  const auto path = folder / "transforms_train.json";
  edit_json(path, [](json& file) { file["k1"] = 0.0, file["p2"] = 0; });
  EXPECT_EQ(read_transforms(folder.path()).frames.size(), 6u);
  edit_json(path, [](json& file) { file["k1"] = 0.01; });
  expect_input_error([&] { read_transforms(folder.path()); }, {"k1 = 0.01", "undistort"});
  edit_json(path, [](json& file) { file["k1"] = 0, file["frames"][2]["p1"] = 1e-4; });
  expect_input_error([&] { read_transforms(folder.path()); }, {"frame 2", "p1", "undistort"});
}

TEST(Transforms, SplitsCanBeStatedByFrameOrByLists) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  std::filesystem::rename(folder / "transforms_train.json", folder / "transforms.json");
  edit_json(folder / "transforms.json", [](json& file) {
    file["frames"][0]["split"] = "test";
    file["val_filenames"] = {"./train/r_001"};
  });
  const TransformsCapture capture = read_transforms(folder.path());
  EXPECT_EQ(capture.frames[0].split, Split::kTest);
  EXPECT_EQ(capture.frames[1].split, Split::kVal);
  EXPECT_EQ(capture.frames[2].split, Split::kTrain);
  edit_json(folder / "transforms.json", [](json& file) { file["frames"][0]["split"] = "exam"; });
  expect_input_error([&] { read_transforms(folder.path()); }, {"exam", "train, val or test"});
}

TEST(Transforms, NamesWithAndWithoutExtension) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  edit_json(folder / "transforms_train.json",
            [](json& file) { file["frames"][1]["file_path"] = "train/../train/r_001.png"; });
  const TransformsCapture capture = read_transforms(folder.path());
  EXPECT_EQ(capture.frames[0].name, "train/r_000");
  EXPECT_EQ(capture.frames[1].name, "train/r_001");
  EXPECT_EQ(capture.frames[1].camera_name, "train");
  EXPECT_EQ(capture.frames[1].frame_number, 1);
  EXPECT_EQ(capture.frames[5].name, "test/r_001");
}

TEST(Transforms, MasksAreWarnedAbout) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  edit_json(folder / "transforms_train.json",
            [](json& file) { file["frames"][1]["mask_path"] = "m.png"; });
  const Scene scene = load_scene(folder.path(), {});
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("masks are not used yet"), std::string::npos);
}

TEST(Transforms, FilesThatAreNoTransformsAreNamed) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& bytes, const std::string& why) {
    write_bytes(folder / "transforms.json", bytes);
    expect_input_error([&] { load_scene(folder.path(), {}); }, {"transforms.json", why});
  };
  expect_input_error([&] { load_scene(folder / "none", {}); }, {"none", "no such folder"});
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"neither", "tessera ingest"});
  refused("", "not valid JSON");
  refused("{\"frames\": [", "not valid JSON");
  refused("{\"frames\": 1e999}", "not valid JSON");
  refused("[1, 2]", "no list 'frames'");
  refused("{\"camera_angle_x\": 0.7}", "no list 'frames'");
  refused("{\"camera_angle_x\": 0.7, \"frames\": []}", "lists no frames");
  refused("{\"frames\": [7]}", "no file_path");
  refused("{\"frames\": [{\"file_path\": 7}]}", "file_path");
  refused("{\"tessera\": 7, \"frames\": [{\"file_path\": \"a\"}]}", "no such picture");
}

}  // namespace
}  // namespace tessera
