// Training on smaller images, and scores at several sizes against the truth of each.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Bugs put back, each seen to fail: the scene trained on as it is; scale 1 taken as the scene's
// size.
TEST(CliScales, AreScoredAgainstTruthOfTheirSize) {
  const CliWorkspace work;
  const json trained =
      work.run_json(work.train_arguments("run", {"--train-scale", "0.5", "--filter-2d", "true"}));
  EXPECT_EQ(trained["scores"]["width"], 16);
  const json scores = work.run_json(
      {"evaluate", work.at("run"), "--scales", "0.5,1,2", "--save-images", work.at("pictures")});
  EXPECT_EQ(scores["scales"].size(), 3u);
  for (const auto& [scale, side] : {std::pair{"0.5", 8}, {"1", 16}, {"2", 32}}) {
    EXPECT_EQ(scores["scales"][scale]["width"], side) << scale;
    EXPECT_GT(scores["scales"][scale]["psnr"], 0) << scale;
  }
  EXPECT_EQ(scores["width"], 16);
  EXPECT_EQ(scores["psnr"], scores["scales"]["1"]["psnr"]);
  EXPECT_TRUE(std::filesystem::exists(work / "pictures/x0.5"));
  EXPECT_TRUE(work.run_json({"info", work.at("run/model.ply")})["filter_2d"]);

  const json one = work.run_json({"evaluate", work.at("run")});
  EXPECT_EQ(one["psnr"], scores["psnr"]);
  EXPECT_EQ(one["scales"].size(), 1u);
  work.expect_refused({"evaluate", work.at("run"), "--scales", "4"}, {"scale 4", "--train-scale"});
  work.expect_refused({"evaluate", work.at("run"), "--scales", "1,0"}, {"--scales has 0"});
}

}  // namespace
}  // namespace tessera::testing
