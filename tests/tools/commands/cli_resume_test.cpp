// A training that was stopped (as planned, by Ctrl-C, by SIGKILL while saving, by a full disk)
// resumes with the result of one that was not. Source: failure modes E5, E6.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class CliResume : public ::testing::Test {
 protected:
  /// Resumes a run. Density control and re-ordering lie on both sides of the stop.
  ChildResult resume(const std::string& run, const std::vector<std::string>& more = {},
                     const ChildLimits& limits = {}) {
    std::vector<std::string> arguments{"train", work.at("capture"), "-o", work.at(run), "--resume"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return work.run(arguments, limits);
  }
  /// One view a step, so that an odd stop falls between the two views of an epoch.
  // clang-format off
  const std::vector<std::string> eventful_{
      "--batch", "1", "--schedule-iterations", "20", "--reorder-interval", "7",
      "--densify-from", "4", "--densify-until", "18", "--densify-interval", "4",
      "--densify-threshold", "1e-6"};
  // clang-format on
  ChildResult train(const std::string& run, std::vector<std::string> more = {}) {
    more.insert(more.end(), eventful_.begin(), eventful_.end());
    return work.train(run, more);
  }
  CliWorkspace work;
};

// Seen to fail with Adam's state left out of what a checkpoint gives back, and with the
// sampler's position left at 0.
TEST_F(CliResume, TwoHalvesAreTheWhole) {
  ASSERT_EQ(train("whole").exit_code, 0);
  ASSERT_EQ(train("halves", {"--stop-after", "9"}).exit_code, 0);
  EXPECT_NE(work.read("whole/model.ply"), work.read("halves/model.ply"));
  const ChildResult resumed = resume("halves");
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(work.read("whole/model.ply"), work.read("halves/model.ply"));
}

// Bugs put back, each seen to fail: the old result printed without a word; --iterations refused;
// scores of the model before that stay.
TEST_F(CliResume, AFinishedTrainingIsSaidToBeOneAndTrainsOnOnRequest) {
  ASSERT_EQ(train("run").exit_code, 0);
  const std::string model = work.read("run/model.ply");
  const ChildResult again = resume("run");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("finished at step 20 of 20"), std::string::npos) << again.err;
  EXPECT_NE(again.err.find("--iterations N"), std::string::npos) << again.err;
  EXPECT_TRUE(work.read("run/model.ply") == model);
  std::ofstream(work / "run/metrics.json") << "{}";  // as `run` and `batch` leave it
  ASSERT_EQ(resume("run").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(work / "run/metrics.json")) << "of this model";
  const ChildResult less = resume("run", {"--iterations", "20"});
  EXPECT_EQ(less.exit_code, 2) << less.err;
  EXPECT_NE(less.err.find("is at step 20"), std::string::npos) << less.err;
  EXPECT_EQ(resume("run", {"--iterations", "30", "--seed", "4"}).exit_code, 2);
  EXPECT_TRUE(work.read("run/model.ply") == model);
  const ChildResult more = resume("run", {"--iterations", "30", "--json"});
  ASSERT_EQ(more.exit_code, 0) << more.err;
  EXPECT_EQ(nlohmann::json::parse(more.out)["iterations"], 30);
  EXPECT_FALSE(work.read("run/model.ply") == model);
  EXPECT_FALSE(std::filesystem::exists(work / "run/metrics.json")) << "of the model before";
}

// Bug put back: names, times and sizes alone compared; seen to fail.
TEST_F(CliResume, AnotherWorldIsRefused) {
  ASSERT_EQ(train("run", {"--stop-after", "9"}).exit_code, 0);
  const std::string before = work.read("capture/transforms_train.json");
  const std::string checkpoint = work.read("run/checkpoint.ckpt");
  const auto expect_refused = [&](const char* what) {
    const ChildResult refused = resume("run");
    EXPECT_EQ(refused.exit_code, 65) << what << refused.err;
    EXPECT_NE(refused.err.find("other frames, cameras or points"), std::string::npos) << what;
    EXPECT_TRUE(work.read("run/checkpoint.ckpt") == checkpoint) << what;
    work.write("capture/transforms_train.json", before);
  };
  work.edit_json("capture/transforms_train.json",
                 [](nlohmann::json& json) { json["frames"][0]["fl_x"] = 55.5; });
  expect_refused("another focal length");
  work.edit_json("capture/transforms_train.json",
                 [](nlohmann::json& json) { json["frames"][0]["transform_matrix"][0][3] = 0.25; });
  expect_refused("another pose");
  EXPECT_EQ(resume("run").exit_code, 0);
}

// Bug put back: an evaluation that a stop cut off is not made up for; seen to fail.
TEST_F(CliResume, AnEvaluationThatAStopCutOffIsMadeUpFor) {
  ASSERT_EQ(train("run", {"--stop-after", "10", "--evaluate-every", "5"}).exit_code, 0);
  std::string log = work.read("run/log.jsonl");
  const size_t last = log.rfind(R"("event":"evaluation")");
  ASSERT_NE(last, std::string::npos);
  const size_t begin = log.rfind('\n', last) + 1, end = log.find('\n', last) + 1;
  log.erase(begin, end - begin);  // as a signal leaves it that comes while step 10 is scored
  work.write("run/log.jsonl", log);
  ASSERT_EQ(resume("run", {"--evaluate-every", "5"}).exit_code, 0);
  std::istringstream lines(work.read("run/log.jsonl"));
  std::vector<int64_t> scored;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json event = nlohmann::json::parse(line);
    if (event["event"] == "evaluation") scored.push_back(event["iteration"]);
  }
  EXPECT_EQ(scored, (std::vector<int64_t>{5, 10, 15, 20}));
}

// Bugs put back: held-out images are decoded; the model is scored in the end; a resumed training
// asks for the same held-out pixels; each seen to fail.
TEST_F(CliResume, ATrainingThatScoresNothingReadsNoHeldOutPixels) {
  ASSERT_EQ(train("scored").exit_code, 0);
  ASSERT_EQ(train("begun", {"--stop-after", "9", "--evaluate-every", "never"}).exit_code, 0);
  ASSERT_EQ(resume("begun").exit_code, 0);
  EXPECT_EQ(work.read("scored/model.ply"), work.read("begun/model.ply"));
  int damaged = 0;
  for (const char* folder : {"capture/test", "capture/val"})
    for (const auto& entry : fs::directory_iterator(work / folder))
      fs::resize_file(entry.path(), 60), ++damaged;  // what is left says the size alone
  ASSERT_GT(damaged, 1);
  const ChildResult refused = train("refused");
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  const ChildResult trained = train("unscored", {"--evaluate-every", "never"});
  EXPECT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_EQ(work.read("scored/model.ply"), work.read("unscored/model.ply"));
  EXPECT_EQ(work.read("unscored/log.jsonl").find(R"("event":"evaluation")"), std::string::npos);
}

// Bug put back: a resumed training takes the options of the command line, which are the defaults;
// seen to fail.
TEST_F(CliResume, TheCheckpointsSeedStays) {
  ASSERT_EQ(train("whole", {"--seed", "7"}).exit_code, 0);
  ASSERT_EQ(train("halves", {"--seed", "7", "--stop-after", "9"}).exit_code, 0);
  ASSERT_EQ(resume("halves").exit_code, 0);
  EXPECT_EQ(work.read("whole/model.ply"), work.read("halves/model.ply"));
}

// Seen to fail with the seed of a training taken from the clock.
TEST_F(CliResume, SameSeedSameBytes) {
  ASSERT_EQ(train("one").exit_code, 0);
  ASSERT_EQ(train("again", {"--threads", "1"}).exit_code, 0);
  ASSERT_EQ(train("other", {"--seed", "2"}).exit_code, 0);
  EXPECT_EQ(work.read("one/model.ply"), work.read("again/model.ply"));
  EXPECT_NE(work.read("one/model.ply"), work.read("other/model.ply"));
}

// Seen to fail with SIGINT left to its default, which ends the program at once, and without the
// last line.
TEST_F(CliResume, CtrlCLeavesACheckpointThatResumes) {
  ChildProcess training(work.train_arguments("run", {"--iterations", "1000000"}), work.path());
  ASSERT_TRUE(training.wait_until([&] { return fs::exists(work / "run/log.jsonl"); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  training.send(SIGINT);
  const ChildResult stopped = training.wait();
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  const int64_t steps =
      work.run_json({"info", work.at("run/checkpoint.ckpt")})["iteration"].get<int64_t>();
  const std::string last = "stopped after " + std::to_string(steps) +
                           " of 1000000 steps; resume with: tessera train " + work.at("capture") +
                           " -o " + work.at("run") + " --resume\n";
  EXPECT_TRUE(stopped.out.ends_with(last)) << stopped.out;
  const ChildResult resumed = resume("run", {"--stop-after", "3"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(work.run_json({"info", work.at("run/checkpoint.ckpt")})["iteration"], steps + 3);
}

// E6. Seen to fail with save_checkpoint writing straight to its target.
TEST_F(CliResume, KilledWhileSavingTheCheckpointStaysWhole) {
  const std::vector<std::string> arguments =
      work.train_arguments("run", {"--iterations", "1000000", "--checkpoint-every", "1",
                                   "--init-points", "8000", "--overwrite"});
  const fs::path checkpoint = work / "run/checkpoint.ckpt";
  for (int round = 0; round < 4; ++round) {
    fs::remove(checkpoint);
    ChildProcess training(arguments, work.path());
    ASSERT_TRUE(training.wait_until([&] { return fs::exists(checkpoint); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(17 * round));
    training.send(SIGKILL);
    EXPECT_EQ(training.wait().signal, SIGKILL);
    const ChildResult info = work.run({"info", checkpoint.string()});
    ASSERT_EQ(info.exit_code, 0) << info.err;
  }
}

// E6. Seen to fail with save_checkpoint writing straight to its target, and with the results of
// fwrite, fflush and fsync ignored.
TEST_F(CliResume, AFullDiskKeepsThePreviousCheckpoint) {
  // as many Gaussians in the end as on the way: the file gets no smaller
  ASSERT_EQ(train("whole", {"--size", "grown"}).exit_code, 0);
  ASSERT_EQ(train("run", {"--size", "grown", "--stop-after", "9"}).exit_code, 0);
  const std::string before = work.read("run/checkpoint.ckpt");
  for (const uint64_t room : {before.size() / 2, before.size() - 1}) {
    const ChildResult failed = resume("run", {}, {room});
    EXPECT_EQ(failed.exit_code, 1) << failed.err;
    EXPECT_NE(failed.err.find("checkpoint.ckpt: cannot be written (File too large)"),
              std::string::npos)
        << failed.err;
    EXPECT_EQ(work.read("run/checkpoint.ckpt"), before);
  }
  for (const auto& entry : fs::directory_iterator(work / "run"))
    EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
  ASSERT_EQ(resume("run").exit_code, 0);
  EXPECT_EQ(work.read("run/model.ply"), work.read("whole/model.ply"));
}

// The failure of a resumed training is not taken for one of its checkpoint, except for one that is
// refused has an exit code of its own. Bugs put back, one each: refused checkpoints as any other
// input (exit code 2); other frames likewise; a run without a checkpoint trained from the beginning
// in its place; each seen to fail.
TEST_F(CliResume, ARefusedCheckpointHasAnExitCodeOfItsOwn) {
  ASSERT_EQ(train("run", {"--stop-after", "9"}).exit_code, 0);
  const std::string before = work.read("run/checkpoint.ckpt");
  EXPECT_EQ(resume("run", {"--time-limit", "0.01"}).exit_code, 2);
  fs::rename(work / "capture", work / "away");
  EXPECT_EQ(resume("run").exit_code, 2);
  fs::rename(work / "away", work / "capture");
  {
    const int held = ::open(work.at("run/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    ASSERT_EQ(::flock(held, LOCK_EX), 0);
    EXPECT_EQ(resume("run").exit_code, 2);
    ::close(held);
  }
  EXPECT_EQ(work.read("run/checkpoint.ckpt"), before);

  work.write("run/checkpoint.ckpt", before.substr(0, before.size() / 2));
  const ChildResult half = resume("run");
  EXPECT_EQ(half.exit_code, 65) << half.err;
  EXPECT_NE(half.err.find("truncated"), std::string::npos) << half.err;
  work.write("run/checkpoint.ckpt", before);
  work.edit_json("capture/transforms_train.json",
                 [](nlohmann::json& file) { file["frames"][0]["time"] = 0.125; });
  const ChildResult other = resume("run");
  EXPECT_EQ(other.exit_code, 65) << other.err;
  EXPECT_NE(other.err.find("other frames"), std::string::npos) << other.err;
  EXPECT_EQ(work.read("run/checkpoint.ckpt"), before);

  const std::string model = work.read("run/model.ply");
  fs::remove(work / "run/checkpoint.ckpt");
  work.expect_refused(
      {"train", work.at("capture"), "-o", work.at("run"), "--resume", "--stop-after", "1"},
      {"no checkpoint.ckpt", "another -o"});
  EXPECT_EQ(work.read("run/model.ply"), model);
}

// Partial files of a killed program are removed by the next training of the run, and by no other.
// Bug put back: leftovers stay; seen to fail.
TEST_F(CliResume, LeftoversOfAKilledProgramGo) {
  ASSERT_EQ(train("run", {"--stop-after", "9"}).exit_code, 0);
  work.write("run/.checkpoint.ckpt.1234567-0.partial", "half of it");
  ASSERT_EQ(resume("run").exit_code, 0);
  EXPECT_FALSE(fs::exists(work / "run/.checkpoint.ckpt.1234567-0.partial"));
}

// The files left by a kill or a full disk before the first checkpoint are no run. Bugs put back: a
// folder with config.json alone is a run; --resume without a checkpoint starts another training; a
// config.json of other programs is ours; each seen to fail.
TEST_F(CliResume, WithoutACheckpointTheFirstCommandRestarts) {
  ASSERT_EQ(train("whole", {"--seed", "7"}).exit_code, 0);
  ASSERT_EQ(train("run", {"--seed", "7", "--stop-after", "1"}).exit_code, 0);
  fs::remove(work / "run/checkpoint.ckpt");
  fs::remove(work / "run/model.ply");
  const std::string config = work.read("run/config.json");
  std::vector<std::string> arguments{"train", work.at("capture"), "-o", work.at("run"), "--resume"};
  const std::vector<std::string> advice{"run: no checkpoint yet; give the first command again"};
  work.expect_refused(arguments, advice);
  arguments.insert(arguments.end(), {"--seed", "7"});
  work.expect_refused(arguments, advice);
  EXPECT_EQ(work.read("run/config.json"), config);
  const ChildResult again = train("run", {"--seed", "7"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(work.read("run/model.ply"), work.read("whole/model.ply"));
  work.expect_refused(work.train_arguments("run"), {"holds a finished run", "changed: "});

  fs::create_directory(work / "other");
  work.write("other/config.json", "{\"name\": \"of another program\"}");
  work.expect_refused(work.train_arguments("other"), {"holds a run already"});
}

// Bugs put back, each seen to fail: the folder renamed before the scene is looked for; renamed
// by a training that another one is in the way of.
TEST_F(CliResume, ARestartThatCannotBeginCostsNothing) {
  ASSERT_EQ(train("run").exit_code, 0);
  const std::string model = work.read("run/model.ply"), config = work.read("run/config.json");
  work.expect_refused({"train", work.at("nowhere"), "-o", work.at("run"), "--overwrite"},
                      {"nowhere"});
  {
    const int held = ::open(work.at("run/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    ASSERT_EQ(::flock(held, LOCK_EX), 0);
    EXPECT_EQ(train("run", {"--overwrite", "--seed", "7"}).exit_code, 2);
    ::close(held);
  }
  EXPECT_EQ(work.read("run/model.ply"), model);
  EXPECT_EQ(work.read("run/config.json"), config);
  EXPECT_FALSE(fs::exists(work / "run.1"));
}

}  // namespace
}  // namespace tessera::testing
