// A training that is stopped by a time limit or by a scheduler's signal ends with exit code 75 and
// resumes with the same result; two trainings never share a run folder. The plan of a limit is
// tested in time_limit_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class CliTimeLimit : public ::testing::Test {
 protected:
  ChildResult resume(const std::string& run, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"train",    work.at("capture"), "-o", work.at(run),
                                       "--resume", "--backend",        "cpu"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return work.run(arguments);
  }
  int64_t steps(const std::string& run) {
    return work.run_json({"info", work.at(run + "/checkpoint.ckpt")})["iteration"].get<int64_t>();
  }
  CliWorkspace work;
};

// Bug put back: a stop by the limit leaves the checkpoint of the last pause; seen to fail.
TEST_F(CliTimeLimit, StopsInTimeAndResumesToTheSameModel) {
  // on a device they would take less than the limit
  const std::vector<std::string> options{"--iterations",       "2500", "--backend", "cpu",
                                         "--checkpoint-every", "0"};
  ASSERT_EQ(work.train("whole", options).exit_code, 0);
  std::vector<std::string> limited = options;
  limited.insert(limited.end(), {"--time-limit", "3"});
  const auto begin = std::chrono::steady_clock::now();
  const ChildResult left = work.train("pieces", limited);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  ASSERT_EQ(left.exit_code, 75) << left.err;
  EXPECT_LT(taken.count(), 5);  // other tests may have the cores while it begins and ends
  EXPECT_NE(left.err.find("--resume goes on"), std::string::npos) << left.err;
  const int64_t first = steps("pieces");
  EXPECT_GT(first, 0);
  EXPECT_LT(first, 2500);
  const ChildResult again = resume("pieces", {"--time-limit", "3s"});
  ASSERT_TRUE(again.exit_code == 75 || again.exit_code == 0) << again.err;
  EXPECT_GT(steps("pieces"), first);
  const ChildResult end = resume("pieces");
  ASSERT_EQ(end.exit_code, 0) << end.err;
  EXPECT_EQ(work.read("pieces/model.ply"), work.read("whole/model.ply"));
}

// Bug put back: report_limit without its look at the first step, so that it leaves with 75 for
// ever; seen to fail.
TEST_F(CliTimeLimit, ALimitWithoutRoomForAStepIsRefused) {
  const ChildResult refused = work.train("run", {"--time-limit", "0.01"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("leave room for no step"), std::string::npos) << refused.err;
  work.expect_refused(work.train_arguments("other", {"--time-limit", "soon"}),
                      {"'soon' is no duration", "1h30m"});
}

// Bug put back: SIGUSR1 left to its default, which ends the program at once; seen to fail.
TEST_F(CliTimeLimit, ASchedulersSignalsLeaveACheckpoint) {
  for (const int signal : {SIGTERM, SIGUSR1}) {
    const std::string run = "run" + std::to_string(signal);
    ChildProcess training(work.train_arguments(run, {"--iterations", "1000000"}), work.path());
    ASSERT_TRUE(training.wait_until([&] { return fs::exists(work / run / "log.jsonl"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    training.send(signal);
    training.send(SIGTERM);  // a scheduler may add this
    const ChildResult left = training.wait();
    EXPECT_EQ(left.exit_code, 75) << left.err;
    const int64_t before = steps(run);
    const ChildResult resumed = resume(run, {"--stop-after", "3"});
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_EQ(steps(run), before + 3);
  }
}

// Bug put back: flock left out; seen to fail.
TEST_F(CliTimeLimit, ASecondTrainingLeavesTheFolderAlone) {
  ChildProcess first(work.train_arguments("run", {"--iterations", "1000000"}), work.path());
  ASSERT_TRUE(first.wait_until([&] { return fs::exists(work / "run/log.jsonl"); }));
  fs::create_directory(work / "elsewhere");
  for (const char* how : {"--overwrite", "--resume"}) {
    const ChildResult second =
        ChildProcess({"train", work.at("capture"), "-o", work.at("run"), how}, work / "elsewhere")
            .wait();
    EXPECT_EQ(second.exit_code, 2);
    EXPECT_EQ(std::count(second.err.begin(), second.err.end(), '\n'), 1) << second.err;
    EXPECT_NE(second.err.find("is training in this folder"), std::string::npos) << second.err;
    EXPECT_NE(second.err.find("process "), std::string::npos) << second.err;
  }
  EXPECT_TRUE(first.running());
  first.send(SIGKILL);
  EXPECT_EQ(first.wait().signal, SIGKILL);
  EXPECT_TRUE(fs::exists(work / "run/lock")) << "a killed one leaves the file, not the lock";
  const ChildResult after = work.run({"train", work.at("capture"), "-o", work.at("run"),
                                      "--overwrite", "--iterations", "5", "--init-points", "300"});
  EXPECT_EQ(after.exit_code, 0) << after.err;
  EXPECT_FALSE(fs::exists(work / "run/lock"));
}

// Bug put back: the folder that was made for the lock is left behind; seen to fail.
TEST_F(CliTimeLimit, ARefusedTrainingLeavesNoFolder) {
  work.expect_refused({"train", work.at("capture"), "-o", work.at("run"), "--resume"},
                      {"nothing to resume"});
  EXPECT_FALSE(fs::exists(work / "run"));
}

}  // namespace
}  // namespace tessera::testing
