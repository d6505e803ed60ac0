// `train` and `ingest` state which views will be scored before a training begins, and these views
// are scored.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Bugs put back: no line before the training; --test-every not used for transforms files; each
// seen to fail.
TEST(CliScored, WhatIsSaidBeforeTrainingIsScoredAfterIt) {
  const CliWorkspace work;
  const ChildResult stated = work.train("run");
  ASSERT_EQ(stated.exit_code, 0) << stated.err;
  EXPECT_NE(stated.err.find("will be scored: 1 test view (camera test), 1 val view (camera val)"),
            std::string::npos)
      << stated.err;

  for (const char* name : {"capture/transforms_test.json", "capture/transforms_val.json"})
    std::filesystem::remove(work / name);
  const ChildResult none = work.train("none");
  ASSERT_EQ(none.exit_code, 0) << none.err;
  EXPECT_NE(none.err.find("nothing will be scored"), std::string::npos) << none.err;
  EXPECT_NE(none.err.find("--test-every 8"), std::string::npos) << none.err;
  EXPECT_EQ(none.out.find("PSNR"), std::string::npos) << none.out;
}

#if TESSERA_HAS_INGEST
// A run whose OUT was moved and made again, and a scene of another size by now. Bugs put
// back, each seen to fail: the scene at the old place before that in OUT; nothing said.
TEST(CliScored, TheSceneIsThatOfTheTrainingOrAWarningSaysSo) {
  const CliWorkspace work;
  for (const char* name : {"capture/transforms_test.json", "capture/transforms_val.json"})
    std::filesystem::remove(work / name);
  const auto ingest = [&](const std::string& scene, const std::string& scale) {
    work.run_json({"ingest", work.at("capture"), "-o", work.at(scene), "--test-every", "2",
                   "--scale", scale, "--overwrite"});
  };
  ingest("out/scene", "1");
  ASSERT_EQ(work.run({"train", work.at("out/scene"), "-o", work.at("out/run"), "--iterations", "2",
                      "--init-points", "100", "--static"})
                .exit_code,
            0);
  const ChildResult before = work.run({"evaluate", work.at("out")});
  EXPECT_EQ(before.err.find("prepared again"), std::string::npos) << before.err;

  std::filesystem::rename(work / "out", work / "kept");
  ingest("out/scene", "0.5");
  const ChildResult moved = work.run({"evaluate", work.at("kept")});
  EXPECT_EQ(moved.out, before.out);
  EXPECT_EQ(moved.err.find("prepared again"), std::string::npos) << moved.err;

  ingest("kept/scene", "0.5");
  const ChildResult changed = work.run({"evaluate", work.at("kept")});
  EXPECT_EQ(changed.exit_code, 0);
  EXPECT_NE(changed.err.find("was prepared again since"), std::string::npos) << changed.err;
  const json report = work.run_json({"report", work.at("kept")});
  EXPECT_NE(report.dump().find("was prepared again since"), std::string::npos) << report.dump(1);
}

TEST(CliScored, TestEveryHoldsFramesOfTransformsFilesOut) {
  const CliWorkspace work;
  for (const char* name : {"capture/transforms_test.json", "capture/transforms_val.json"})
    std::filesystem::remove(work / name);
  const json report =
      work.run_json({"ingest", work.at("capture"), "-o", work.at("scene"), "--test-every", "2"});
  EXPECT_EQ(report["test_views"], 1);
  const ChildResult trained = work.run({"train", work.at("scene"), "-o", work.at("run"),
                                        "--iterations", "2", "--init-points", "100", "--static"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("will be scored: 1 test view (1 of the 2 of camera train)"),
            std::string::npos)
      << trained.err;
  EXPECT_NE(trained.out.find("test views (1): PSNR"), std::string::npos) << trained.out;
}
#endif

}  // namespace
}  // namespace tessera::testing
