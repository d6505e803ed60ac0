// A capture whose world is normalised: exports, camera files and scores through the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "ingest/files/point_cloud.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A room with its true surface points as initial cloud, trained for a timestep.
class CliWorld : public ::testing::Test {
 protected:
  void SetUp() override {
    const ChildResult made = work_.run(
        {"synth", "room", "-o", work_.at("room"), "--layout", "n3dv", "--cameras", "4", "--frames",
         "2", "--width", "32", "--height", "32", "--supersampling", "1", "--points", "500"});
    if (made.exit_code != 0) GTEST_SKIP() << "no video encoder: " << made.err;
    fs::copy(work_ / "room/ground_truth/points.ply", work_ / "room/points.ply");
    ASSERT_EQ(work_.run({"ingest", work_.at("room"), "-o", work_.at("scene")}).exit_code, 0);
    const ChildResult trained =
        work_.run({"train", work_.at("scene"), "-o", work_.at("run"), "--iterations", "4",
                   "--init-points", "500", "--batch", "1", "--motion", "none"});
    ASSERT_EQ(trained.exit_code, 0) << trained.err;
  }
  json bounds(const std::string& name) const {
    return work_.run_json({"info", work_.at(name)})["bounds"];
  }
  CliWorkspace work_;
};

json bounds_of_points(const fs::path& folder) {
  std::vector<std::string> warnings;
  glm::vec3 low(INFINITY);
  glm::vec3 high(-INFINITY);
  for (const glm::vec3& p : find_points(folder, "", warnings).position) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return {{"min", {low[0], low[1], low[2]}}, {"max", {high[0], high[1], high[2]}}};
}

double largest_difference(const json& a, const json& b) {
  double largest = 0;
  for (const char* end : {"min", "max"})
    for (size_t k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(a[end][k].get<double>() - b[end][k].get<double>()));
  return largest;
}

// Bugs put back: the model exported as it is; its size stated in the prepared scene's world; each
// seen to fail.
TEST_F(CliWorld, ExportsComeOutWhereTheCaptureIs) {
  const json truth = bounds_of_points(work_ / "room");
  ASSERT_EQ(
      work_.run({"export", work_.at("run"), "-o", work_.at("frames"), "--time", "0"}).exit_code, 0);
  // Four steps move a mean by less than 4 × its learning rate, 1.6e-4 of the extent.
  EXPECT_LT(largest_difference(bounds("frames/frame_0000.ply"), truth), 0.05);
  ASSERT_EQ(work_.run({"export", work_.at("run"), "-o", work_.at("model"), "--format", "model"})
                .exit_code,
            0);
  EXPECT_LT(largest_difference(bounds("model/model.ply"), truth), 0.05);
  EXPECT_EQ(work_.run_json({"info", work_.at("model/model.ply")})["world"], "source");
  EXPECT_EQ(work_.run_json({"info", work_.at("run")})["world"], "prepared");
  ASSERT_EQ(
      work_.run({"export", work_.at("run/checkpoint.ckpt"), "-o", work_.at("early"), "--time", "0"})
          .exit_code,
      0);
  EXPECT_LT(largest_difference(bounds("early/frame_0000.ply"), truth), 0.05);
  ASSERT_EQ(
      work_.run({"export", work_.at("run"), "-o", work_.at("kept"), "--time", "0", "--keep-world"})
          .exit_code,
      0);
  EXPECT_GT(largest_difference(bounds("kept/frame_0000.ply"), truth), 0.5);
  EXPECT_EQ(json::parse(work_.read("frames/manifest.json"))["world"], "source");
  EXPECT_EQ(json::parse(work_.read("kept/manifest.json"))["world"], "prepared");
  ASSERT_EQ(work_
                .run({"export", work_.at("run"), "-o", work_.at("single"), "--format", "tessera",
                      "--single"})
                .exit_code,
            0);
  const json info = work_.run_json({"info", work_.at("run"), "--shipped"});
  EXPECT_EQ(info["shipped_bytes"], fs::file_size(work_ / "single/scene.t4d"));
}

// Bug put back: cameras taken as in the model's world against their file; seen to fail.
TEST_F(CliWorld, CamerasOfEitherWorldSeeTheSame) {
  ASSERT_EQ(work_.run({"export", work_.at("run"), "-o", work_.at("model"), "--format", "model"})
                .exit_code,
            0);
  ASSERT_EQ(
      work_.run({"ingest", work_.at("room"), "-o", work_.at("kept"), "--keep-world"}).exit_code, 0);
  // The kept scene's cameras without the field that names their scene: a foreign file.
  json foreign = json::parse(work_.read("kept/transforms.json"));
  foreign.erase("tessera");
  for (json& frame : foreign["frames"]) frame.erase("tessera");
  work_.write("foreign.json", foreign.dump());
  const auto psnr = [&](const std::string& model, const std::string& scene) {
    return work_.run_json({"evaluate", work_.at(model), "--scene", work_.at(scene)})["psnr"]
        .get<double>();
  };
  const double expected = psnr("run", "scene");
  EXPECT_NEAR(psnr("run", "kept"), expected, 1e-3);
  EXPECT_NEAR(psnr("model/model.ply", "scene"), expected, 1e-3);
  EXPECT_NEAR(psnr("model/model.ply", "kept"), expected, 1e-3);
  // Images of the run by foreign cameras are those by its own.
  const auto render = [&](const std::string& cameras, const std::string& out) {
    const ChildResult result =
        work_.run({"render", work_.at("run"), "--cameras", work_.at(cameras), "-o", work_.at(out),
                   "--split", "test", "--time", "0", "--float"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return work_.read(out + "/cam00/00000.pfm");
  };
  const std::string own_world = render("scene", "own"), other = render("foreign.json", "other");
  ASSERT_EQ(own_world.size(), other.size());
  const size_t pixels = own_world.size() - size_t(32 * 32 * 3 * 4);
  double worst = 0;
  for (size_t i = pixels; i < own_world.size(); i += 4) {
    float a = 0, b = 0;
    std::copy_n(own_world.data() + i, 4, reinterpret_cast<char*>(&a));
    std::copy_n(other.data() + i, 4, reinterpret_cast<char*>(&b));
    worst = std::max(worst, double(std::abs(a - b)));
  }
  EXPECT_LT(worst, 0.01);
}

}  // namespace
}  // namespace tessera::testing
