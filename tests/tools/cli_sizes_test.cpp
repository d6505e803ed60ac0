// What: pictures of several sizes and focal lengths in one scene, from ingest to scores.
// Not: the equations of one camera, which the libraries' tests check.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// B9. Two cameras of 640 × 480 and 1280 × 720 look at one object. The larger picture shows more of
// the empty surroundings: its score may be that of its share of object pixels better, no more.
// Bug put back: the first picture's size and focal length for all (set_intrinsics); seen to fail.
TEST(CliSizes, TwoCamerasOfDifferentSizesTrainTogether) {
  const CliWorkspace work;
  json merged{{"frames", json::array()}};
  const std::pair<const char*, std::pair<const char*, const char*>> sizes[] = {
      {"small", {"640", "480"}}, {"large", {"1280", "720"}}};
  for (const auto& [name, size] : sizes) {
    const auto made =
        work.run({"synth", "object", "-o", work.at(std::string("both/") + name), "--layout",
                  "dnerf", "--frames", "3", "--held-out-frames", "1", "--width", size.first,
                  "--height", size.second, "--supersampling", "1", "--points", "500"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    for (const char* split : {"train", "test"}) {
      const json file =
          json::parse(work.read(std::string("both/") + name + "/transforms_" + split + ".json"));
      for (json frame : file["frames"]) {
        std::string picture = frame["file_path"];
        frame["file_path"] = std::string(name) + "/" + picture.substr(2);
        frame["split"] = split;
        if (!frame.contains("fl_x")) frame["camera_angle_x"] = file["camera_angle_x"];
        frame.erase("time");
        merged["frames"].push_back(frame);
      }
    }
  }
  work.write("both/transforms.json", merged.dump());
  const auto ingested = work.run({"ingest", work.at("both"), "-o", work.at("scene")});
  if (ingested.err.find("trainer-only") != std::string::npos) GTEST_SKIP() << "trainer-only build";
  ASSERT_EQ(ingested.exit_code, 0) << ingested.err;
  const auto trained = work.run({"train", work.at("scene"), "-o", work.at("run"), "--iterations",
                                 "60", "--init-points", "2000", "--batch", "2"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const json scores = work.run_json({"evaluate", work.at("run"), "--split", "test"});
  ASSERT_EQ(scores["per_view"].size(), 2u);
  double psnr[2];
  for (size_t i = 0; i < 2; ++i) psnr[i] = scores["per_view"][i]["psnr"];
  EXPECT_GT(std::min(psnr[0], psnr[1]), 15) << scores["per_view"];
  EXPECT_LT(std::abs(psnr[0] - psnr[1]), 2.5) << scores["per_view"];
}

}  // namespace
}  // namespace tessera::testing
