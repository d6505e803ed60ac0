// What is stated of a camera is taken, refused or named: keys in any spelling, and keys that no
// reader knows.
#include "ingest/poses/stated_object.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <random>

#include "ingest/poses/rig_poses_file.h"
#include "ingest/prepared/transforms_json.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

json entry() {
  return {{"K", {{100, 0, 60}, {0, 110, 40}, {0, 0, 1}}},
          {"R", {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}},
          {"T", {1, 2, 3}},
          {"w", 120},
          {"h", 80}};
}

json with(const json& more) {
  json object = entry();
  object.update(more);
  return object;
}

struct ReadRig {
  std::vector<RigCamera> cameras;
  std::vector<std::string> notes;
};

ReadRig read(const json& camera, json file = json::object()) {
  file["cameras"] = {{"cam07", camera}};
  ReadRig rig;
  rig.cameras = rig_cameras_of(file, "rig.json", rig.notes);
  return rig;
}

// Bugs put back, each seen to fail: keys that are not read count as read; a list of spellings.
TEST(StatedObject, KnowsWhatWasReadInAnySpelling) {
  const json values = {{"Camera-Matrix", 1}, {"K", 2}, {"none", nullptr}, {"zeros", {0, 0}}};
  const StatedObject object(values, "here");
  EXPECT_EQ(object.named({"mtx", "cameramatrix"}).key, "Camera-Matrix");
  EXPECT_FALSE(object.has("D"));
  ASSERT_EQ(object.rest().size(), 1u);
  EXPECT_EQ(object.rest()[0].key, "K");
  EXPECT_EQ(object.number("K"), 2);
  EXPECT_TRUE(object.rest().empty());
  EXPECT_EQ(plain_key("dist_Coeffs2"), "distcoeffs2");
}

// Bugs put back, each seen to fail: distCoef not read (14.5 dB for 17.2); the model of the
// distortion not looked at.
TEST(StatedObject, LensesAreReadUnderKeysOfTheirKind) {
  const json four = {0.1, 0.2, 0.03, 0.04};
  const Lens lens = read(with({{"D", four}})).cameras[0].lens;
  EXPECT_EQ(lens.p1, 0.03);
  for (const char* key : {"distCoef", "DistCoeffs", "distortion", "distortion_coefficients",
                          "dist-params", "Distortion_Vector"})
    EXPECT_EQ(read(with({{key, four}})).cameras[0].lens, lens) << key;
  EXPECT_EQ(read(entry(), {{"distCoef", four}}).cameras[0].lens, lens) << "of the file";
  for (const char* model : {"plumb_bob", "radtan", "rational_polynomial", "Brown-Conrady"})
    EXPECT_EQ(read(with({{"D", four}, {"distortion_model", model}})).cameras[0].lens, lens);
  for (const json& more : {json{{"distortion_model", "equidistant"}},
                           json{{"camera_model", "pinhole"}, {"distortion_model", "equidistant"}},
                           json{{"lens_model", "Kannala-Brandt"}}, json{{"fisheye", 1}}}) {
    json camera = with(more);
    camera["D"] = four;
    EXPECT_EQ(read(camera).cameras[0].lens.projection, Lens::Projection::kFisheye) << more;
  }
  EXPECT_TRUE(read(with({{"dist", json::array()}})).cameras[0].lens.is_pinhole());
}

// Bug put back: what a lens or a pose is stated by is dropped; seen to fail.
TEST(StatedObject, KeysOfALensOrAPoseThatNoReaderKnowsAreRefused) {
  std::mt19937 random(7);
  const auto refused = [&](const std::vector<std::string>& words, const json& value) {
    for (const std::string& word : words)
      for (int i = 0; i < 4; ++i) {
        const std::string key = fmt::format("x{}_{}{}", random() % 100, word, random() % 100);
        expect_input_error([&] { read(with({{key, value}})); }, {"rig.json", "cam07", key});
      }
  };
  const std::vector<std::string> lens{"distort", "coefs", "radial", "Fisheye", "tangentials"};
  for (const json& value : {json{0.1, 0.2}, json{{"a", 1}}}) {
    refused(lens, value);
    refused({"rotation", "quat", "pose", "c2w", "skew", "Euler", "world"}, value);
  }
  refused(lens, 0.1);
  refused({"distortion_fit", "convention", "handedness"}, "some");
  for (const char* key : {"lensType", "projection_model"})
    expect_input_error([&] { read(with({{key, "some"}})); }, {key});
  expect_input_error(
      [&] {
        read(with({{"D", {1, 2, 3, 4}}, {"distortion_model", "mei"}}));
      },
      {"distortion_model 'mei'"});
  expect_input_error([&] { read(entry(), {{"lens_correction", {1, 2}}}); }, {"lens_correction"});
}

// Bugs put back, each seen to fail: every key a warning; lists dropped.
TEST(StatedObject, OtherKeysAreNamedOnceWhereTheyCouldMatter) {
  const ReadRig rig = read(with({{"serial", "0012"},
                                 {"rms", 0.3},
                                 {"panel", 4},
                                 {"type", "vga"},
                                 {"rectification_matrix", {1, 2}},
                                 {"board", {9, 6}}}),
                           {{"date", "today"}, {"flags", {1, 2}}, {"lens", "24 mm"}});
  ASSERT_EQ(rig.notes.size(), 1u);
  EXPECT_EQ(rig.notes[0], "rig.json: not read: board, flags, rectification_matrix");
  EXPECT_TRUE(
      read(with({{"rotation", 0.3}, {"distances", 0.5}, {"lens", nullptr}, {"coefs", {0, 0}}}))
          .notes.empty());
}

// Bugs put back, each seen to fail: D_NAME and others dropped; a rig of L and R taken for a camera.
TEST(StatedObject, NamesBehindKeysAndCamerasOfOneLetter) {
  std::vector<std::string> notes;
  json file = {{"K_a_1", entry()["K"]},
               {"Rot_a_1", entry()["R"]},
               {"T_a_1", {1, 2, 3}},
               {"distCoef_a_1", {0.1, 0, 0, 0}}};
  const auto cameras = rig_cameras_of(file, "rig.json", notes);
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].name, "a_1");
  EXPECT_EQ(cameras[0].lens.k1, 0.1);
  file["lensfit_a_1"] = {1, 2};
  expect_input_error([&] { rig_cameras_of(file, "rig.json", notes); }, {"camera a_1", "lensfit"});
  EXPECT_EQ(rig_cameras_of({{"L", entry()}, {"R", entry()}}, "rig.json", notes).size(), 2u);
}

// Bugs put back, each seen to fail: the last row not read (all cameras at the origin); keys of a
// transforms file dropped.
TEST(StatedObject, TransformsFilesAreReadWhole) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  const auto path = folder / "transforms_train.json";
  edit_json(path, [](json& file) {
    file["aabb"] = {1, 2, 3};
    file["applied_transform"] = {1, 2, 3};
    file["frames"][1]["rotation"] = 0.03;
    file["frames"][1]["depth_file_path"] = "a.png";
  });
  const TransformsCapture capture = read_transforms_capture(folder.path());
  EXPECT_EQ(capture.notes.back(), path.string() + ": not read: aabb, applied_transform");
  edit_json(path, [](json& file) { file["frames"][2]["distortion_params"] = {0.1, 0.2}; });
  expect_input_error([&] { read_transforms_capture(folder.path()); },
                     {"frame 2", "distortion_params"});
  edit_json(path, [](json& file) {
    file["frames"][2].erase("distortion_params");
    json& matrix = file["frames"][3]["transform_matrix"];
    for (size_t i = 0; i < 3; ++i) std::swap(matrix[3][i], matrix[i][3]);
  });
  expect_input_error([&] { read_transforms_capture(folder.path()); },
                     {"frame 3", "last row", "row by row"});
}

}  // namespace
}  // namespace tessera
