// `tessera train --resume=auto`: what it does by what the run folder holds and what is asked for.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class CliResumeAuto : public ::testing::Test {
 protected:
  const CliWorkspace work;
};

std::vector<std::string> with_auto(std::vector<std::string> more) {
  more.insert(more.begin(), "--resume=auto");
  return more;
}

// Bugs put back: a finished run of another request replaced without --overwrite; done before though
// the scene has changed; the key has the place of the scene; the checkpoint of another request
// removed; seen to fail.
TEST_F(CliResumeAuto, DecidesByWhatIsThereAndWhatIsAskedFor) {
  const auto train_auto = [&](std::vector<std::string> more) {
    return work.train("run", with_auto(std::move(more)));
  };
  EXPECT_EQ(train_auto({"--stop-after", "2"}).exit_code, 0);
  const auto rest = train_auto({});
  EXPECT_EQ(rest.exit_code, 0);
  EXPECT_EQ(rest.err.find("refused"), std::string::npos) << rest.err;
  EXPECT_FALSE(fs::exists(work / "run/checkpoint.refused")) << "resumed";
  const auto model = fs::last_write_time(work / "run/model.ply");

  const auto again = train_auto({});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.out.find("done before, unchanged"), std::string::npos) << again.out;
  EXPECT_EQ(fs::last_write_time(work / "run/model.ply"), model);
  fs::rename(work / "capture", work / "moved");
  auto moved = work.train_arguments("run", with_auto({}));
  moved[1] = work.at("moved");
  EXPECT_EQ(work.run(moved).exit_code, 0) << "a copy of a scene is the same scene";
  fs::rename(work / "moved", work / "capture");

  work.expect_refused(work.train_arguments("run", with_auto({"--seed", "5"})),
                      {"holds a finished run", "changed: seed 1 → 5", "--overwrite"});
  EXPECT_EQ(fs::last_write_time(work / "run/model.ply"), model);
  EXPECT_EQ(train_auto({"--seed", "5", "--overwrite"}).exit_code, 0);
  EXPECT_GT(fs::last_write_time(work / "run/model.ply"), model);
  work.write("capture/transforms_train.json", work.read("capture/transforms_train.json") + " ");
  work.expect_refused(work.train_arguments("run", with_auto({"--seed", "5"})),
                      {"changed: the files of the scene"});
}

// Bug put back: the steps that the training was begun with, though it was given more; seen to fail.
TEST_F(CliResumeAuto, KnowsWhatAResumedTrainingWasBegunWith) {
  EXPECT_EQ(work.train("run", {"--seed", "3", "--stop-after", "2"}).exit_code, 0);
  EXPECT_EQ(
      work.run({"train", work.at("capture"), "-o", work.at("run"), "--resume", "--backend", "cpu"})
          .exit_code,
      0);
  const auto again = work.train("run", with_auto({"--seed", "3"}));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("done before, unchanged"), std::string::npos);
  EXPECT_EQ(work.run({"train", work.at("capture"), "-o", work.at("run"), "--resume", "--backend",
                      "cpu", "--iterations", "24"})
                .exit_code,
            0);
  work.expect_refused(work.train_arguments("run", with_auto({"--seed", "3"})),
                      {"changed: iterations 24 → 20"});
}

// Bugs put back: another request overwrites the checkpoint of hours; that of a training that runs
// is renamed; seen to fail.
TEST_F(CliResumeAuto, SetsTheCheckpointOfAnotherRequestAside) {
  EXPECT_EQ(work.train("run", {"--stop-after", "2"}).exit_code, 0);
  {
    const int held = ::open(work.at("run/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    ASSERT_EQ(::flock(held, LOCK_EX), 0);
    EXPECT_EQ(work.train("run", with_auto({"--seed", "9"})).exit_code, 2) << "it is in use";
    ::close(held);
    EXPECT_FALSE(fs::exists(work / "run/checkpoint.refused"));
  }
  const auto other = work.train("run", with_auto({"--seed", "9"}));
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_NE(other.err.find("changed: seed 1 → 9"), std::string::npos) << other.err;
  EXPECT_TRUE(fs::exists(work / "run/checkpoint.refused"));
  EXPECT_EQ(json::parse(work.read("run/config.json"))["seed"], 9);
}

// Bug put back: a training is taken for finished where it has a model, and a checkpoint that cannot
// be read; seen to fail.
TEST_F(CliResumeAuto, StartsAnewWhereTheCheckpointIsDamaged) {
  EXPECT_EQ(work.train("run", {"--stop-after", "2"}).exit_code, 0);
  const std::string checkpoint = work.read("run/checkpoint.ckpt");
  work.write("run/checkpoint.ckpt", checkpoint.substr(0, checkpoint.size() / 2));
  const auto anew = work.train("run", with_auto({}));
  EXPECT_EQ(anew.exit_code, 0) << anew.err;
  EXPECT_NE(anew.err.find("the training starts anew"), std::string::npos) << anew.err;
  EXPECT_EQ(work.read("run/checkpoint.refused").size(), checkpoint.size() / 2);
  work.write("run/checkpoint.ckpt", "none");
  const auto again = work.train("run", with_auto({}));
  EXPECT_NE(again.out.find("done before, unchanged"), std::string::npos) << "it needs none";
}

}  // namespace
}  // namespace tessera::testing
