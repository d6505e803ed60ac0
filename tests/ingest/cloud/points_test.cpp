// Initial clouds: how they are found and checked, and the files that are refused.
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/ply.h"
#include "ingest/files/point_cloud.h"
#include "ingest/prepared/scene_reader.h"
#include "tests/ingest/layouts/capture_fixture.h"

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
  EXPECT_EQ(load_scene(folder.path(), {}).warnings.back(),
            (folder / "none.ply").string() + ": no such file; there is no initial cloud");
  write_bytes(folder / "bad.ply", "no ply");
  state("bad.ply");
  expect_input_error([&] { load_scene(folder.path(), {}); }, {"bad.ply", "ply"});
}

// Bug put back: write_points leaves the columns out; seen to fail.
TEST(Points, TimesAndStillSurviveTheFile) {
  const TemporaryFolder folder;
  PointCloud points{{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0, 0, 1}}, {}, {}, {}, {}};
  points.colour.resize(4);
  points.time = {0, 0.1f, 1, NAN};
  points.still = {1, 0, PointCloud::kStillUnknown, 1};
  write_points(folder / "points.ply", points);
  std::vector<std::string> warnings;
  const PointCloud read = find_points(folder.path(), "", warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(read.still, points.still);
  ASSERT_EQ(read.time.size(), 4u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(read.time[i], points.time[i]);
  EXPECT_TRUE(std::isnan(read.time[3]));
  points.time.clear();
  points.still.clear();
  write_points(folder / "points.ply", points);
  const PointCloud plain = find_points(folder.path(), "", warnings);
  EXPECT_EQ(plain.position, points.position);
  EXPECT_TRUE(plain.time.empty() && plain.still.empty());
}

// Bugs put back: columns not thinned with the points that are not finite; 1.5 taken as a time.
TEST(Points, TimesOutsideTheClipAreNotKnown) {
  const TemporaryFolder folder;
  PlyFile file = cloud_with({1, std::nan(""), 3, 4, 5});
  file.elements[0].columns.push_back({"time", PlyType::kFloat32, {1.5, 0.25, 0.5, INFINITY, -0.1}});
  file.elements[0].columns.push_back({"still", PlyType::kUint8, {0, 0, 1, 7, 1}});
  write_ply(folder / "points.ply", file);
  std::vector<std::string> warnings;
  const PointCloud points = find_points(folder.path(), "", warnings);
  ASSERT_EQ(points.time.size(), 4u);
  EXPECT_TRUE(std::isnan(points.time[0]));
  EXPECT_EQ(points.time[1], 0.5f);
  EXPECT_TRUE(std::isnan(points.time[2]) && std::isnan(points.time[3]));
  EXPECT_EQ(points.still, (std::vector<uint8_t>{0, 1, PointCloud::kStillUnknown, 1}));
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("3 of 4 points have times outside"), std::string::npos) << warnings[0];
  file.elements[0].columns[4].values.assign(5, std::nan(""));
  write_ply(folder / "points.ply", file);
  EXPECT_TRUE(find_points(folder.path(), "", warnings).time.empty()) << "no point has a time";
}

// Bugs put back: the columns not written; those of the points before a point that is not finite
// taken; each seen to fail.
TEST(Points, VelocitiesSurviveTheFile) {
  const TemporaryFolder folder;
  PointCloud points{{{1, 2, 3}, {NAN, 5, 6}, {7, 8, 9}}, {}, {}, {}, {}};
  points.colour.resize(3);
  points.velocity = {{0.5f, -1, 1e-7f}, {1, 1, 1}, {0, NAN, 3}};
  write_points(folder / "points.ply", points);
  std::vector<std::string> warnings;
  const std::vector<glm::vec3> expected{{0.5f, -1, 1e-7f}, {0, 0, 0}};
  EXPECT_EQ(find_points(folder.path(), "", warnings).velocity, expected);
}

// Bug put back: the velocities of `more` left out; seen to fail.
TEST(Points, AddedPointsKeepTheirVelocities) {
  const PointCloud still{{{1, 2, 3}}, {{}}, {}, {}, {}};
  PointCloud cloud = still;
  add_points(cloud, {{{4, 5, 6}}, {{}}, {}, {}, {{7, 8, 9}}});
  add_points(cloud, still);
  EXPECT_EQ(cloud.velocity, (std::vector<glm::vec3>{{0, 0, 0}, {7, 8, 9}, {0, 0, 0}}));
}

// Bug put back: velocities left as they are; seen to fail.
TEST(Points, AnotherTimeAxis) {
  PointCloud points{
      {{1, 2, 3}, {4, 5, 6}}, {{}, {}}, {0.25f, 0.75f}, {0, 0}, {{1, 2, 3}, {0, 0, 4}}};
  change_time_axis(points, {10, 4}, {10, 2});  // the first half of the clip
  EXPECT_EQ(points.time[0], 0.5f);
  EXPECT_TRUE(std::isnan(points.time[1]));
  EXPECT_EQ(points.velocity[1], glm::vec3(0, 0, 2)) << "half as far in half of the time";
}

}  // namespace
}  // namespace tessera
