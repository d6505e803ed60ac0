// What: initial clouds: found, checked, and refused when they are something else.
// Not: PLY itself (ply_test.cpp).
#include <cmath>

#include "ingest/files/ply.h"
#include "ingest/scene_reader.h"
#include "tests/ingest/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

PlyFile cloud_with(const std::vector<double>& x) {
  PlyElement vertex{"vertex", int64_t(x.size()), {}};
  for (const char* name : {"x", "y", "z"}) vertex.columns.push_back({name, PlyType::kFloat32, x});
  vertex.columns.push_back({"red", PlyType::kUint8, std::vector<double>(x.size(), 200)});
  return {{}, {vertex}};
}

TEST(Points, FoundByNameAndCheckedForNaN) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  EXPECT_TRUE(load_scene(folder.path(), {}).points.position.empty());
  write_ply(folder / "points3d.ply", cloud_with({1, std::nan(""), 3}));
  const Scene scene = load_scene(folder.path(), {});
  ASSERT_EQ(scene.points.position.size(), 2u);
  EXPECT_EQ(scene.points.position[1], glm::vec3(3));
  EXPECT_EQ(scene.points.colour[1], (std::array<uint8_t, 3>{200, 128, 128}));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("1 of 3 points are not finite"), std::string::npos);
}

// Bug put back: the look for f_dc_0 removed; seen to fail.
TEST(Points, GaussianModelsAndOtherFilesAreNoClouds) {
  const TemporaryFolder folder;
  write_dnerf(folder.path(), {});
  PlyFile model = cloud_with({1, 2});
  model.elements[0].columns.push_back({"f_dc_0", PlyType::kFloat32, {0, 0}});
  write_ply(folder / "points.ply", model);
  const Scene scene = load_scene(folder.path(), {});
  EXPECT_TRUE(scene.points.position.empty());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("3D Gaussian model"), std::string::npos);
  const auto state = [&](const char* name) {
    edit_json(folder / "transforms_train.json", [&](json& file) { file["ply_file_path"] = name; });
  };
  state("points.ply");
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"points.ply", "3D Gaussian model"});
  state("none.ply");
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"none.ply", "No such file"});
  write_bytes(folder / "bad.ply", "no ply");
  state("bad.ply");
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"bad.ply", "ply"});
}

}  // namespace
}  // namespace tessera
