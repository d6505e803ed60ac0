// No command writes into its input, whatever the path is, and no result of hours is replaced
// without --overwrite; a refusal leaves no files. Source: failure mode F18.
#include <gtest/gtest.h>

#include <map>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class CliOutputPlace : public ::testing::Test {
 protected:
  /// Everything in the workspace but what the last child has said: names and bytes.
  std::map<std::string, std::string> everything() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(work.path())) {
      const std::string name = fs::relative(entry.path(), work.path()).string();
      if (!name.starts_with("child_std"))
        all[name] = entry.is_regular_file() ? work.read(name) : "";
    }
    return all;
  }
  /// Refused with a line that has every part, and nothing is written anywhere.
  void refused(const Words& words, const Words& parts) const {
    const auto before = everything();
    work.expect_refused(words, parts);
    EXPECT_TRUE(everything() == before) << words[0];
  }
  Words train(const std::string& out) const { return work.train_arguments(out); }
  Words run(const std::string& out) const {
    Words words = work.train_arguments(out);
    words[0] = "run";
    return words;
  }

  CliWorkspace work;
};

// Bugs put back, one each: the output made before it is compared; names compared without following
// links; an output that contains the input let pass; each seen to fail.
TEST_F(CliOutputPlace, RunAndIngestNeverWriteIntoTheCapture) {
  fs::create_directory_symlink(work / "capture", work / "link");
  fs::create_directory(work / "folder");
  fs::create_directory_symlink(work / "capture/train", work / "folder/inside");
  const Words ingest{"ingest", work.at("capture"), "-o"};
  for (const char* out : {"capture", "link", "link/../link", "capture/"}) {
    refused(run(out), {"never written to", "choose another folder"});
    refused({"ingest", work.at("capture"), "-o", work.at(out), "--overwrite"},
            {"never written to"});
  }
  for (const char* out : {"capture/out", "link/new/deep", "folder/inside/out"}) {
    refused(run(out), {"lies in", work.at("capture"), "outside"});
    refused({"ingest", work.at("capture"), "-o", work.at(out)}, {"lies in", work.at("capture")});
  }
  refused(run("."), {"contains the input", "beside it"});
  refused({"ingest", work.at("capture"), "-o", work.path().parent_path()}, {"contains the input"});
  EXPECT_EQ(work.run(run("beside")).exit_code, 0) << "a sibling is no such place";
}

// Bugs put back: stages.json made before the capture is checked; the engine searched for after the
// batch was written; seen to fail.
TEST_F(CliOutputPlace, WhatIsNoCaptureLeavesNothing) {
  fs::create_directory(work / "empty");
  for (const char* capture : {"empty", "nowhere"}) {
    Words words = run("out");
    words[1] = work.at(capture);
    refused(words, {work.at(capture)});
  }
}

TEST_F(CliOutputPlace, TrainingsNeither) {
  refused(train("capture"), {"never written to"});
  refused(train("capture/run"), {"lies in", "outside"});
  refused(train("."), {"contains the input"});
}

// Bug put back: a run folder's scene is not looked up; seen to fail.
TEST_F(CliOutputPlace, WhatIsMadeOfAModelNeither) {
  ASSERT_EQ(work.train("run").exit_code, 0);
  for (const char* out : {"capture/new", "capture/train/new"}) {
    refused({"export", work.at("run"), "-o", work.at(out)}, {"lies in", work.at("capture")});
    refused({"render", work.at("run"), "--path", "orbit", "-o", work.at(out)}, {"lies in"});
    refused({"evaluate", work.at("run"), "--save-images", work.at(out)}, {"lies in"});
  }
  refused({"export", work.at("run"), "-o", work.at("capture"), "--overwrite"},
          {"never written to"});
  fs::rename(work / "capture", work / "moved");
  refused({"render", work.at("run"), "--cameras", work.at("moved"), "-o", work.at("moved/x")},
          {"lies in", work.at("moved")});
  const ChildResult inside = work.run({"export", work.at("run"), "-o", work.at("run/export")});
  EXPECT_EQ(inside.exit_code, 0) << "a run folder is no such input: " << inside.err;
}

// Files of those names may be somebody's own. Bugs put back: a training, a run and a report replace
// them, and a report empties its images/; each seen to fail.
TEST_F(CliOutputPlace, FilesThatNoRunHasWrittenStay) {
  for (const char* file : {"mine/model.ply", "mine/log.jsonl"}) {
    work.write(file, "mine");
    refused(train("mine"), {work.at(file), "move it away"});
    fs::remove(work / file);
  }
  for (const char* file :
       {"mine/run/metrics.json", "mine/player/index.html", "mine/frames/a.ply"}) {
    work.write(file, "mine");
    work.expect_refused(run("mine"), {"no "});
    EXPECT_TRUE(work.read(file) == "mine") << file;
    fs::remove(work / file);
  }
  ASSERT_EQ(work.train("run").exit_code, 0);
  work.write("mine/images/000.jpg", "mine");  // as that of a reconstruction by COLMAP
  refused({"report", work.at("run"), "-o", work.at("mine")}, {"did not write", "--overwrite"});
  EXPECT_EQ(work.run({"report", work.at("run"), "-o", work.at("mine"), "--overwrite"}).exit_code,
            0);
  EXPECT_EQ(work.read("mine/images/000.jpg"), "mine");
}

// Each command knows its own files. Bugs put back, each seen to fail: a folder of one is that of
// all; what another has written goes.
TEST_F(CliOutputPlace, ResultsOfAnotherCommandStay) {
  ASSERT_EQ(work.train("run").exit_code, 0);
  ASSERT_EQ(work.run({"export", work.at("run"), "-o", work.at("x"), "--format", "spz"}).exit_code,
            0);
  const Words images{"evaluate", work.at("run"), "--save-images", work.at("x")},
      render{"render", work.at("run"), "-o", work.at("x"), "--path", "orbit", "--seconds", "0.1"};
  refused(images, {"did not write", "--overwrite"});
  const auto before = everything();
  EXPECT_EQ(work.run(render).exit_code, 2);
  EXPECT_TRUE(everything() == before);
  Words over = render;
  over.emplace_back("--overwrite");
  EXPECT_EQ(work.run(over).exit_code, 0);
  EXPECT_TRUE(fs::exists(work / "x/frame_0000.spz"));
}

// Bugs put back, one each: a prepared scene replaced without a word; a made capture likewise; files
// of somebody go with a scene; a link becomes a folder; each seen to fail.
TEST_F(CliOutputPlace, WhatTookHoursIsReplacedWithOverwriteOnly) {
  TESSERA_SKIP_WITHOUT_INGEST();
  const Words ingest{"ingest", work.at("capture"), "-o", work.at("scene")};
  ASSERT_EQ(work.run(ingest).exit_code, 0);
  refused(ingest, {"scene", "--overwrite"});
  Words over = ingest;
  over.emplace_back("--overwrite");
  work.write("scene/notes.txt", "mine");
  work.write("scene/train/mine/a.png", "mine");
  work.write("scene/train/r_999.png", "mine");
  EXPECT_EQ(work.run(over).exit_code, 0);
  for (const char* file : {"scene/notes.txt", "scene/train/mine/a.png", "scene/train/r_999.png"})
    EXPECT_EQ(work.read(file), "mine") << "is none of the scene's";
  fs::rename(work / "scene", work / "elsewhere");
  fs::create_directory_symlink(work / "elsewhere", work / "scene");
  EXPECT_EQ(work.run(over).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(work / "scene"));
  EXPECT_EQ(work.read("elsewhere/notes.txt"), "mine");
  const Words synth{"synth", "object",  "-o", work.at("capture"), "--layout", "dnerf", "--frames",
                    "2",     "--width", "24", "--height",         "24"};
  refused(synth, {"capture", "--overwrite"});
  over = synth;
  over.emplace_back("--overwrite");
  EXPECT_EQ(work.run(over).exit_code, 0);
}

}  // namespace
}  // namespace tessera::testing
