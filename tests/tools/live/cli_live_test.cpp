// A training that is viewed while it runs: the files in RUN/live, and equality with a training that
// is not viewed. Source: docs/reference/run-folder.md.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "tests/tools/commands/cli_workspace.h"
#include "tools/live/live_folder.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

/// A viewer that requests the state of a run continuously.
class Watcher {
 public:
  explicit Watcher(const fs::path& run) : run_(run), live(run) {}

  /// Asks, as `tessera view` does once a second.
  void ask() {
    if (!fs::exists(run_ / "config.json")) return;
    if (!fs::exists(live.root()) && request.stop_training.empty()) live.make();
    ++request.counter;
    if (const auto state = live.state()) request.seen = state->snapshot;
    live.write(request);
  }

 private:
  fs::path run_;

 public:
  LiveFolder live;
  LiveRequest request;
};

// Bugs put back: stop_training of another training stops this one; RUN/live stays; each seen to
// fail.
TEST(CliLive, AViewedTrainingIsShownAndStopsOnRequest) {
  const CliWorkspace work;
  const ScratchFolder scratch;
  ChildProcess child(work.train_arguments("run", {"--iterations", "1000000"}), scratch.path());
  Watcher watcher(work / "run");
  LiveState state;
  ASSERT_TRUE(child.wait_until([&] {
    watcher.ask();
    state = watcher.live.state().value_or(LiveState{});
    if (state.snapshot == 1) watcher.request.stop_training = "another";
    return state.snapshot >= 2;
  })) << child.err_so_far();
  EXPECT_EQ(state.total, 1000000);
  EXPECT_GT(state.step, 0);
  EXPECT_GT(state.seconds_left, 60) << "of a million steps";
  EXPECT_GT(state.snapshot_step, 0);
  EXPECT_LE(state.snapshot_step, state.step);
  EXPECT_GT(state.num_static + state.num_dynamic, 0);
  EXPECT_TRUE(state.model_failure.empty()) << state.model_failure;
  struct stat folder {};
  ASSERT_EQ(::stat(watcher.live.root().c_str(), &folder), 0);
  EXPECT_EQ(folder.st_mode & 0777, 0700u) << "for its owner alone";
  EXPECT_FALSE(fs::exists(watcher.live.snapshot(state.snapshot - 2)));
  const fs::path newest = watcher.live.snapshot(state.snapshot), kept = work / "kept.t4d";
  fs::copy_file(newest, kept);
  const ChildResult info = work.run({"info", kept.string()});
  EXPECT_EQ(info.exit_code, 0) << info.err;

  watcher.request.stop_training = state.training;
  ASSERT_TRUE(child.running());
  child.wait_until([&] {
    watcher.ask();
    return false;
  });
  const ChildResult ended = child.wait();
  EXPECT_EQ(ended.exit_code, 75) << ended.err;
  EXPECT_TRUE(fs::exists(work / "run/checkpoint.ckpt"));
  EXPECT_FALSE(fs::exists(watcher.live.root()));
}

TEST(CliLive, WatchedOrNotItIsTheSameTraining) {
  const CliWorkspace work;
  const std::vector<std::string> longer = {"--iterations", "3000"};
  const ScratchFolder scratch;
  ChildProcess child(work.train_arguments("watched", longer), scratch.path());
  Watcher watcher(work / "watched");
  int64_t snapshots = 0;
  child.wait_until([&] {
    watcher.ask();
    if (const auto state = watcher.live.state()) snapshots = std::max(snapshots, state->snapshot);
    return false;
  });
  ASSERT_EQ(child.wait().exit_code, 0);
  EXPECT_GT(snapshots, 0) << "it was too short to be seen";
  ASSERT_EQ(work.train("alone", longer).exit_code, 0);
  EXPECT_EQ(work.read("watched/model.ply"), work.read("alone/model.ply"));
}

TEST(CliLive, WithoutAViewerNoFilesAreLeft) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  EXPECT_FALSE(fs::exists(work / "run/live"));
}

TEST(LiveFolder, WhatIsDamagedIsNotThere) {
  const CliWorkspace work;
  const LiveFolder folder(work / "run");
  EXPECT_FALSE(folder.state());
  folder.make();
  folder.make();
  for (const char* text : {"", "{", "[1]", R"({"counter": "x"})", "\xff\xfe"}) {
    work.write("run/live/state.json", text);
    work.write("run/live/request.json", text);
    EXPECT_FALSE(folder.state()) << text;
    EXPECT_FALSE(folder.request()) << text;
  }
  LiveState state;
  state.training = "a1";
  state.loss = 0.25;
  state.snapshot = 7;
  ASSERT_TRUE(folder.write(state));
  ASSERT_TRUE(folder.state());
  EXPECT_EQ(folder.state()->training, "a1");
  EXPECT_EQ(folder.state()->loss, 0.25);
  EXPECT_EQ(folder.state()->snapshot, 7);
}

}  // namespace
}  // namespace tessera::testing
