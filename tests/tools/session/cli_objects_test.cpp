// `evaluate --boxes` with the boxes of a synthetic rig, and files of boxes that do not fit the
// scene.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

constexpr size_t kFrames = 8;

/// A tiny training on the rig of `synth fast`, whose held-out camera is cam00.
class CliObjects : public ::testing::Test {
 protected:
  CliObjects() {
    const auto done = [&](const std::vector<std::string>& arguments) {
      const ChildResult result = work.run(arguments);
      EXPECT_EQ(result.exit_code, 0) << arguments[0] << ": " << result.err;
    };
    done({"synth", "fast", "-o", work.at("fast"), "--cameras", "4", "--frames",
          std::to_string(kFrames), "--width", "96", "--height", "72", "--points", "50",
          "--supersampling", "2"});
    done({"ingest", work.at("fast"), "-o", work.at("scene"), "--sync", "none"});
    done({"train", work.at("scene"), "-o", work.at("run"), "--iterations", "20", "--init-points",
          "600", "--batch", "2", "--decide-motion", "false"});
  }
  CliWorkspace work;
};

/// Mean of the squared differences at range 1 over the pixels of the box.
double box_error(const Image8& drawn, const Image8& truth, const json& box) {
  double sum = 0, count = 0;
  for (int y = box[1]; y < box[3]; ++y)
    for (int x = box[0]; x < box[2]; ++x)
      for (size_t c = 0; c < 3; ++c, ++count) {
        const size_t i = 3 * size_t(y * truth.width + x) + c;
        sum += std::pow((drawn.data[i] - truth.data[i]) / 255.0, 2);
      }
  return sum / count;
}

// Bug put back: boxes of the timestep before; seen to fail.
TEST_F(CliObjects, AreScoredInTheirBoxes) {
  const std::string boxes = work.at("fast/ground_truth.json");
  const json scores = work.run_json(
      {"evaluate", work.at("run"), "--boxes", boxes, "--save-images", work.at("images")});
  const json truth = json::parse(work.read("fast/ground_truth.json"));
  const json& of_camera = truth["cameras"][0]["boxes"];
  ASSERT_TRUE(scores["objects"].is_array());
  int seen = 0;
  for (const json& object : scores["objects"]) {
    const json& list = of_camera[object["name"].get<std::string>()];
    for (const json& timestep : object["timesteps"]) {
      const size_t frame = timestep["frame_number"];
      char name[32];
      std::snprintf(name, sizeof(name), "cam00/%05zu.png", frame);
      const double error =
          box_error(read_png(work / "images" / name), read_png(work / "scene" / name), list[frame]);
      EXPECT_NEAR(timestep["psnr"], -10 * std::log10(error), 1e-6) << object["name"] << frame;
      EXPECT_LE(object["worst"]["psnr"], timestep["psnr"]);
      ++seen;
    }
  }
  EXPECT_GT(seen, 4 * int(kFrames));
  EXPECT_FALSE(work.run_json({"evaluate", work.at("run")}).contains("objects"));
  const ChildResult text = work.run({"evaluate", work.at("run"), "--boxes", boxes});
  EXPECT_NE(text.out.find("thrown ball"), std::string::npos) << text.out;
}

// Bug put back: numbers of frames ignored; seen to fail.
TEST_F(CliObjects, BoxesThatDoNotFitAreNamed) {
  const auto refused = [&](const std::string& file, const std::vector<std::string>& parts) {
    work.expect_refused({"evaluate", work.at("run"), "--boxes", work.at(file)}, parts);
  };
  refused("none.json", {"none.json"});
  work.write("bare.json", "{\"cameras\": [{\"name\": \"cam00\"}]}");
  refused("bare.json", {"bare.json", "no boxes", "tessera synth"});
  work.edit_json("fast/ground_truth.json", [](json& truth) {
    for (json& list : truth["cameras"][0]["boxes"]) list.erase(list.size() - 1);
  });
  refused("fast/ground_truth.json", {"ground_truth.json", "7 frames", "cam00", "all frames"});
  work.edit_json("fast/ground_truth.json",
                 [](json& truth) { truth["cameras"][0]["name"] = "left"; });
  refused("fast/ground_truth.json", {"ground_truth.json", "no camera cam00"});
}

}  // namespace
}  // namespace tessera::testing
