// A scene is not replaced while a program reads it and not read while one replaces it. Source:
// failure mode F19.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <csignal>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class CliSceneLock : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(work.run({"ingest", work.at("capture"), "-o", work.at("scene")}).exit_code, 0);
  }
  std::vector<std::string> train(const std::string& scene) const {
    std::vector<std::string> words = work.train_arguments("run", {"--iterations", "1000000"});
    words[1] = work.at(scene);
    return words;
  }
  CliWorkspace work;
};

// Bug put back: a training takes no lock of its scene; seen to fail.
TEST_F(CliSceneLock, ASceneInUseIsNotReplaced) {
  const auto written = fs::last_write_time(work / "scene/transforms.json");
  fs::create_directory(work / "child");
  ChildProcess training(train("scene"), work / "child");
  ASSERT_TRUE(training.wait_until([&] { return fs::exists(work / "run/log.jsonl"); }));
  work.expect_refused(
      {"ingest", work.at("capture"), "-o", work.at("scene"), "--overwrite"},
      {work.at("scene"), work.read("run/lock"), "has this scene in use", "stop it"});
  training.send(SIGINT);
  EXPECT_EQ(training.wait().exit_code, 130);
  EXPECT_EQ(fs::last_write_time(work / "scene/transforms.json"), written);
  EXPECT_EQ(
      work.run({"ingest", work.at("capture"), "-o", work.at("scene"), "--overwrite"}).exit_code, 0);
}

// A capture that a training reads as it is has the same protection, and no file is added to it.
// Bug put back: the lock only of scenes with a transforms.json; seen to fail.
TEST_F(CliSceneLock, NorACaptureThatIsAScene) {
  fs::create_directory(work / "child");
  const auto files = [&] {
    return std::distance(fs::recursive_directory_iterator(work / "capture"), {});
  };
  const auto before = files();
  ChildProcess training(train("capture"), work / "child");
  ASSERT_TRUE(training.wait_until([&] { return fs::exists(work / "run/log.jsonl"); }));
  EXPECT_EQ(files(), before);
  work.expect_refused({"synth", "object", "-o", work.at("capture"), "--overwrite"},
                      {work.at("capture"), "has this scene in use"});
  training.send(SIGINT);
  EXPECT_EQ(training.wait().exit_code, 130);
}

// Bug put back: readers wait for no lock; seen to fail.
TEST_F(CliSceneLock, ASceneThatIsBeingReplacedIsNotRead) {
  const int scene = ::open(work.at("scene/transforms.json").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(::flock(scene, LOCK_EX), 0);
  std::vector<std::string> short_training = train("scene");
  short_training.insert(short_training.end(), {"--stop-after", "1"});
  work.expect_refused(short_training, {work.at("scene"), "process " + std::to_string(::getpid()),
                                       "is replacing this scene"});
  ASSERT_EQ(::flock(scene, LOCK_SH), 0);
  EXPECT_EQ(work.run(short_training).exit_code, 0) << "readers do not disturb each other";
  ::close(scene);
}

}  // namespace
}  // namespace tessera::testing
