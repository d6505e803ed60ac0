// `tessera train`: what it does by what the run folder holds and what is asked for.
#include <gtest/gtest.h>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class CliResumeAuto : public ::testing::Test {
 protected:
  const CliWorkspace work;
};

// Bugs put back: done before though the scene has changed; the key has the place of the scene; seen
// to fail.
TEST_F(CliResumeAuto, KnowsASceneByItsContents) {
  ASSERT_EQ(work.train("run").exit_code, 0);
  const auto model = fs::last_write_time(work / "run/model.ply");
  fs::rename(work / "capture", work / "moved");
  auto moved = work.train_arguments("run", {});
  moved[1] = work.at("moved");
  EXPECT_EQ(work.run(moved).exit_code, 0) << "a copy of a scene is the same scene";
  EXPECT_EQ(fs::last_write_time(work / "run/model.ply"), model);
  fs::rename(work / "moved", work / "capture");

  work.write("capture/transforms_train.json", work.read("capture/transforms_train.json") + " ");
  work.expect_refused(work.train_arguments("run", {}), {"changed: the contents of the scene"});
}

// Bug put back: the steps that the training was begun with, though it was given more; seen to fail.
TEST_F(CliResumeAuto, KnowsWhatAResumedTrainingWasBegunWith) {
  EXPECT_EQ(work.train("run", {"--seed", "3", "--stop-after", "2"}).exit_code, 0);
  EXPECT_EQ(
      work.run({"train", work.at("capture"), "-o", work.at("run"), "--resume", "--backend", "cpu"})
          .exit_code,
      0);
  const auto again = work.train("run", {"--seed", "3"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("done before, unchanged"), std::string::npos);
  EXPECT_EQ(work.run({"train", work.at("capture"), "-o", work.at("run"), "--resume", "--backend",
                      "cpu", "--iterations", "24"})
                .exit_code,
            0);
  work.expect_refused(work.train_arguments("run", {"--seed", "3"}),
                      {"changed: iterations 24 → 20"});
}

// Bug put back: a training is taken for finished where it has a model, and a checkpoint that cannot
// be read; seen to fail.
TEST_F(CliResumeAuto, StartsAnewWhereTheCheckpointIsDamaged) {
  EXPECT_EQ(work.train("run", {"--stop-after", "2"}).exit_code, 0);
  const std::string checkpoint = work.read("run/checkpoint.ckpt");
  work.write("run/checkpoint.ckpt", checkpoint.substr(0, checkpoint.size() / 2));
  const auto anew = work.train("run", {});
  EXPECT_EQ(anew.exit_code, 0) << anew.err;
  EXPECT_NE(anew.err.find("the training starts anew"), std::string::npos) << anew.err;
  EXPECT_EQ(work.read("run.1/checkpoint.ckpt").size(), checkpoint.size() / 2);
  work.write("run/checkpoint.ckpt", "none");
  const auto again = work.train("run", {});
  EXPECT_NE(again.out.find("done before, unchanged"), std::string::npos) << "it needs none";
}

}  // namespace
}  // namespace tessera::testing
