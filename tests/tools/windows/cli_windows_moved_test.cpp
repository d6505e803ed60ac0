// Windows whose scene was moved, and those of a Tessera 4D file without their folder.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/windows/cli_windows_fixture.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Bugs put back, each seen to fail: --scene refused; the core of a window not told where its scene
// is found by content (other frames are scored); windows.json names the old place after training
// was repeated; the old place preferred where another scene lies there by now.
TEST_F(CliWindows, FollowTheirScene) {
  work.run_json(train("run"));
  const std::vector<std::string> evaluate{"evaluate", work.at("run"), "--backend", "cpu"};
  const json before = work.run_json(evaluate);
  const WrittenFiles models = work.written("run", "model.ply");
  fs::rename(work / "scene", work / "elsewhere");
  work.expect_refused(evaluate,
                      {"its scene", "is gone; put it back there, or repeat the training"});
  std::vector<std::string> stated = evaluate;
  stated.insert(stated.end(), {"--scene", work.at("elsewhere")});
  const json found = work.run_json(stated);
  EXPECT_EQ(found["per_view"], before["per_view"]);
  EXPECT_EQ(found["scene"], work.at("elsewhere"));
  EXPECT_EQ(work.run_json({"evaluate", work.at("run/windows/0001"), "--backend", "cpu", "--scene",
                           work.at("elsewhere")})["per_view"]
                .size(),
            24u);

  std::vector<std::string> again = train("run");
  again[1] = work.at("elsewhere");
  work.run_json(again);
  EXPECT_EQ(work.written("run", "model.ply"), models) << "nothing is trained again";
  EXPECT_EQ(json::parse(work.read("run/windows.json"))["scene"], work.at("elsewhere"));
  EXPECT_EQ(work.run_json({"info", work.at("run")})["scene"], work.at("elsewhere"));
  EXPECT_EQ(work.run_json(evaluate)["per_view"], before["per_view"]);
  ASSERT_EQ(work.run({"ingest", work.at("room"), "-o", work.at("scene"), "--cloud", "none",
                      "--frames-as", "video", "--frames", "24"})
                .exit_code,
            0);
  EXPECT_EQ(work.run_json(evaluate)["per_view"], before["per_view"]);
}

// Bugs put back, each seen to fail: a file of windows refused; each window scored on all frames.
TEST_F(CliWindows, OfAFileAreRenderedAndScored) {
  work.run_json(train("run"));
  const json whole = work.run_json({"evaluate", work.at("run"), "--backend", "cpu"});
  work.run_json({"export", work.at("run"), "-o", work.at("clip"), "--format", "tessera",
                 "--lossless", "--single"});
  const json scores = work.run_json(
      {"evaluate", work.at("clip/scene.t4d"), "--scene", work.at("scene"), "--backend", "cpu"});
  EXPECT_EQ(scores["windows"], 2);
  EXPECT_EQ(scores["per_view"].size(), 48u);
  EXPECT_NEAR(double(scores["psnr"]), double(whole["psnr"]), 0.3);
  EXPECT_EQ(scores["bytes"], fs::file_size(work / "clip/scene.t4d"));
  const json rendered =
      work.run_json({"render", work.at("clip/scene.t4d"), "-o", work.at("images"), "--cameras",
                     work.at("scene"), "--split", "test", "--backend", "cpu"});
  EXPECT_EQ(rendered["windows"], 2);
  EXPECT_EQ(rendered["count"], 48);
  work.expect_refused(
      {"export", work.at("clip/scene.t4d"), "-o", work.at("a.ply"), "--format", "ply"},
      {"holds 2 windows", "name the run of a window"});
}

}  // namespace
}  // namespace tessera::testing
