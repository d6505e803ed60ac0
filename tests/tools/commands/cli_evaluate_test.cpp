// `tessera evaluate` beyond one model's PSNR and SSIM: several runs, LPIPS, frames per second.
// Source: failure modes D1, D8.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"
#include "tests/tools/lpips/onnx_file.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Bug put back: all pixels loaded; seen to fail.
TEST(CliEvaluate, OnlyWhatIsScoredIsDecoded) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  const json whole = work.run_json({"evaluate", work.at("run")});
  std::filesystem::resize_file(work / "capture/train/r_000.png", 60);  // the header with its size
  EXPECT_EQ(work.run_json({"evaluate", work.at("run")}), whole);
  work.expect_refused({"evaluate", work.at("run"), "--split", "train"}, {"r_000.png"});
}

// Bugs put back, each seen to fail: n in place of n − 1; numbers of the last run alone; no look at
// the scenes.
TEST(CliEvaluate, SeveralRunsHaveMeanAndSigma) {
  const CliWorkspace work;
  for (const char* seed : {"1", "2", "3"})
    ASSERT_EQ(work.train("seed" + std::string(seed), {"--seed", seed}).exit_code, 0);
  const json together =
      work.run_json({"evaluate", work.at("seed1"), work.at("seed2"), work.at("seed3")});
  ASSERT_EQ(together["runs"].size(), 3u);
  EXPECT_EQ(together["count"], 3);
  double mean = 0, square = 0;
  for (const json& run : together["runs"]) mean += double(run["psnr"]) / 3;
  for (const json& run : together["runs"]) square += std::pow(double(run["psnr"]) - mean, 2);
  const json& psnr = together["splits"]["test"]["psnr"];
  EXPECT_NEAR(psnr["mean"], mean, 1e-12);
  EXPECT_NEAR(psnr["sigma"], std::sqrt(square / 2), 1e-12);
  EXPECT_GT(psnr["sigma"], 0);
  EXPECT_TRUE(together["splits"]["val"]["ssim"]["mean"].is_number());
  EXPECT_TRUE(together["splits"]["test"]["num_gaussians"]["sigma"].is_number());
  EXPECT_FALSE(together["splits"]["test"].contains("per_view"));
  EXPECT_EQ(together["runs"][1], work.run_json({"evaluate", work.at("seed2")}));
  work.edit_json("seed3/config.json", [&](json& config) { config["scene"] = work.at("seed1"); });
  work.expect_refused({"evaluate", work.at("seed1"), work.at("seed3")},
                      {"different scenes", "--scene"});
}

// Bug put back: frame rate of one frame; seen to fail.
TEST(CliEvaluate, TimesTheRenderer) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  const json scores = work.run_json({"evaluate", work.at("run"), "--fps"});
  const json& rate = scores["frame_rate"];
  EXPECT_GT(rate["fps"], 1);
  EXPECT_EQ(rate["frames"], 300);
  EXPECT_EQ(rate["width"], 32);
  EXPECT_EQ(rate["num_gaussians"], scores["num_gaussians"]);
  EXPECT_TRUE(rate["clock"] == "host" || rate["clock"] == "device events");
  EXPECT_FALSE(work.run_json({"evaluate", work.at("run")}).contains("frame_rate"));
}

// Bug put back: the network not handed to the evaluation; seen to fail.
TEST(CliEvaluate, LpipsByAFileOrAClearLine) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  work.write("net.onnx", onnx_file());
  const std::vector<std::string> arguments{"evaluate", work.at("run"), "--lpips",
                                           work.at("net.onnx")};
  if (!TESSERA_HAS_LPIPS) {
    work.expect_refused(arguments, {"net.onnx", "without OpenCV"});
    return;
  }
  const json scores = work.run_json(arguments);
  EXPECT_GT(scores["lpips"], 0);
  EXPECT_GT(scores["per_view"][0]["lpips"], 0);
  EXPECT_TRUE(work.run_json({"evaluate", work.at("run")})["lpips"].is_null());
  OnnxNetwork fixed;
  fixed.width = fixed.height = 16;
  work.write("net.onnx", onnx_file(fixed));
  work.expect_refused(arguments, {"16 x 16", "32 x 32", "--lpips-resize"});
  std::vector<std::string> resized = arguments;
  resized.push_back("--lpips-resize");
  EXPECT_GT(work.run_json(resized)["lpips"], 0);
}

}  // namespace
}  // namespace tessera::testing
