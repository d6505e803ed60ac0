// `tessera ingest` and `tessera run` on a folder of captures: invalid captures in every position,
// unusual names, and captures that are already done.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A folder `all` of good captures with odd names and bad ones before, between and behind.
class CliBatch : public ::testing::Test {
 protected:
  const std::vector<std::string> bad_ = {"a corrupt", "m corrupt", "z corrupt", "empty"};
  const std::vector<std::string> good_ = {"b plain", "k 'quoted' \"twice\"", "ü Küche 厨房"};

  void SetUp() override {
    fs::create_directories(work_ / "all");
    for (const std::string& name : good_) fs::copy(work_ / "capture", place(name), kTree);
    for (const std::string& name : bad_) fs::create_directories(place(name));
    work_.write("all/a corrupt/transforms.json", "{\"frames\": [");
    work_.write("all/m corrupt/cam00.mp4", "no video at all");
    work_.write("all/m corrupt/poses_bounds.npy", "no array");
    work_.write("all/z corrupt/transforms_train.json", "");
    fs::create_directories(place(".hidden"));
    work_.write("all/.hidden/transforms.json", "{");
    work_.write("all/notes.txt", "a file is no scene");
  }
  fs::path place(const std::string& name) const { return work_ / ("all/" + name); }
  ChildResult ingest(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"ingest", work_.at("all"), "-o", work_.at("out")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return work_.run(arguments);
  }
  static int64_t lines(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  }

  static constexpr auto kTree = fs::copy_options::recursive;
  CliWorkspace work_;
};

// Bug put back: the first error ends the batch; seen to fail.
TEST_F(CliBatch, ContinuesPastInvalidCapturesAndListsThem) {
  const ChildResult result = ingest();
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_EQ(lines(result.out), 1 + 7 + 1) << result.out;  // heading, a line a scene, the sum
  EXPECT_NE(result.out.find("3 done, 0 unchanged, 4 failed"), std::string::npos) << result.out;
  for (const std::string& name : good_) {
    EXPECT_TRUE(fs::exists(work_ / ("out/" + name + "/transforms.json"))) << name;
    EXPECT_NE(result.out.find(name), std::string::npos);
  }
  for (const std::string& name : bad_) {
    EXPECT_FALSE(fs::exists(work_ / ("out/" + name))) << name;
    EXPECT_NE(result.out.find(name), std::string::npos);
  }
  EXPECT_EQ(result.out.find(".hidden"), std::string::npos);
  EXPECT_EQ(result.out.find("notes.txt"), std::string::npos);
  for (const auto& entry : fs::directory_iterator(work_ / "out"))
    EXPECT_EQ(entry.path().filename().string().find(".partial"), std::string::npos);
}

// Bug put back: the key without the options; seen to fail.
TEST_F(CliBatch, WhatIsDoneAndUnchangedIsLeftAlone) {
  for (const std::string& name : bad_) fs::remove_all(place(name));
  ASSERT_EQ(ingest().exit_code, 0);
  const fs::path scene = work_ / ("out/" + good_[0] + "/transforms.json");
  const auto written = fs::last_write_time(scene);
  const ChildResult again = ingest({"--json"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  const json list = json::parse(again.out);
  ASSERT_EQ(list.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(list[i]["name"], good_[i]);
    EXPECT_EQ(list[i]["outcome"], "unchanged");
    EXPECT_EQ(list[i]["layout"], "transforms");
    EXPECT_EQ(list[i]["frames"], 4);
    EXPECT_TRUE(list[i].contains("seconds"));
  }
  EXPECT_EQ(fs::last_write_time(scene), written);
  EXPECT_NE(again.err.find("done before, unchanged"), std::string::npos);
  // Another option, another capture, a lost scene: done again, and those alone.
  fs::remove_all(work_ / ("out/" + good_[1]));
  work_.edit_json("all/" + good_[2] + "/transforms_test.json",
                  [](json& file) { file["frames"][0]["time"] = 0.75; });
  const json third = json::parse(ingest({"--json"}).out);
  EXPECT_EQ(third[0]["outcome"], "unchanged");
  EXPECT_EQ(third[1]["outcome"], "done");
  EXPECT_EQ(third[2]["outcome"], "done");
  for (const json& line : json::parse(ingest({"--json", "--scale", "0.5"}).out))
    EXPECT_EQ(line["outcome"], "done");
}

TEST_F(CliBatch, BrokenLinksAndUnreadableFoldersAreALineEach) {
  for (const std::string& name : bad_) fs::remove_all(place(name));
  fs::create_directory_symlink("loop", place("loop"));
  fs::create_directory_symlink(work_ / "all", place("self"));
  fs::create_directory_symlink("nowhere", place("dangling"));
  int64_t failing = 3;
  if (::geteuid() != 0) {  // root may read everything
    fs::create_directories(place("locked"));
    fs::permissions(place("locked"), fs::perms::none);
    ++failing;
  }
  const ChildResult result = ingest({"--json"});
  if (failing == 4) fs::permissions(place("locked"), fs::perms::owner_all);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  const json list = json::parse(result.out);
  EXPECT_EQ(int64_t(list.size()), 3 + failing);
  int64_t failed = 0;
  for (const json& line : list) {
    if (line["outcome"] != "failed") continue;
    ++failed;
    EXPECT_EQ(lines(line["error"]), 0) << line;
    EXPECT_NE(line["error"].get<std::string>().find(line["name"].get<std::string>()),
              std::string::npos)
        << line;
  }
  EXPECT_EQ(failed, failing);
}

TEST_F(CliBatch, NothingThereIsRefusedAndAmbiguityIsDecided) {
  fs::create_directories(work_ / "none/empty");
  work_.expect_refused({"ingest", work_.at("none"), "-o", work_.at("out")}, {"none", "name the"});
  work_.expect_refused({"ingest", work_.at("none"), "-o", work_.at("out"), "--batch"},
                       {"none of its 1 subfolders is a capture"});
  // A capture whose subfolder is one too: the capture itself, or with --batch the subfolder.
  fs::rename(place(good_[0]), work_ / "capture/inner");
  EXPECT_EQ(work_.run_json({"ingest", work_.at("capture"), "-o", work_.at("outer")})["frames"], 4);
  const ChildResult inner =
      work_.run({"ingest", work_.at("capture"), "-o", work_.at("inners"), "--batch", "--json"});
  EXPECT_TRUE(fs::exists(work_ / "inners/inner/transforms.json")) << inner.err;
}

// Seen to fail with detect_layout's own message, which names no capture.
TEST_F(CliBatch, RunNamesTheCapturesAndTheRemedy) {
  for (const std::string& name : bad_) fs::remove_all(place(name));
  work_.expect_refused({"run", work_.at("all"), "-o", work_.at("out")},
                       {"b plain", "name one of them", "tessera ingest"});
}

// Ctrl-C keeps finished captures; the next run continues from there.
// Bug put back: Interrupted taken for a scene's error; seen to fail.
TEST_F(CliBatch, CtrlCKeepsWhatIsDone) {
  for (const std::string& name : bad_) fs::remove_all(place(name));
  const std::string last = good_[2];
  work_.edit_json("all/" + last + "/transforms_train.json", [&](json& file) {
    for (int i = 0; i < 3000; ++i) {
      fs::create_hard_link(place(last) / "train/r_000.png",
                           place(last) / ("train/x_" + std::to_string(i) + ".png"));
      file["frames"].push_back(file["frames"][0]);
      file["frames"].back()["file_path"] = "./train/x_" + std::to_string(i);
    }
  });
  ChildProcess running({"ingest", work_.at("all"), "-o", work_.at("out")}, work_.path());
  ASSERT_TRUE(running.wait_until([&] {
    for (const auto& entry :
         fs::directory_iterator(fs::exists(work_ / "out") ? work_ / "out" : fs::path(work_.path())))
      if (entry.path().filename().string().starts_with("." + last)) return true;
    return false;
  }));
  running.send(SIGINT);
  const ChildResult stopped = running.wait();
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_NE(stopped.out.find("2 done"), std::string::npos) << stopped.out;
  EXPECT_TRUE(fs::exists(work_ / ("out/" + good_[0] + "/transforms.json")));
  EXPECT_FALSE(fs::exists(work_ / ("out/" + last)));
}

}  // namespace
}  // namespace tessera::testing
