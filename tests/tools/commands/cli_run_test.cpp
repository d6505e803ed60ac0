// `tessera run`: every stage once, only changed or missing stages again, and its output.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/commands/cli_workspace.h"
#include "tools/web/web_page.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class CliRun : public ::testing::Test {
 protected:
  ChildResult run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = work.train_arguments("out", more);
    arguments[0] = "run";
    return work.run(arguments);
  }
  /// Whether the program carries the player's page.
  static bool plays() { return carries_pages(); }
  /// The stages of a run from one on.
  static std::string from(const std::string& stage) {
    const std::string all =
        "ingest train evaluate export " + std::string(plays() ? "page " : "") + "report ";
    return all.substr(all.find(stage));
  }
  /// The stages that ran, in order, from the output of the program.
  static std::string begun(const ChildResult& result) {
    std::string stages;
    int number = 0;
    for (const std::string stage : {"ingest", "train", "evaluate", "export", "page", "report"}) {
      const std::string title = fmt::format("[{}/6] {}", ++number, stage);
      if (stage == "page" && !plays()) continue;
      const size_t end = result.err.find(title + ": done in ");
      const bool ran = end != std::string::npos;
      if (ran && (stage == "ingest" || stage == "train")) {
        EXPECT_LT(std::min(result.err.find(title + "\n"), result.err.find(title + " again: ")), end)
            << result.err;
      }
      const bool kept = result.err.find(title + ": done before, unchanged") != std::string::npos;
      const bool unwanted = stage == "export" && result.err.find(title) == std::string::npos;
      EXPECT_EQ(int(ran) + int(kept) + int(unwanted), 1) << result.err;
      if (ran) stages += stage + " ";
    }
    return stages;
  }
  CliWorkspace work;
};

TEST_F(CliRun, MakesModelScoresAndFrames) {
  const ChildResult result = run({"--json", "--export-frames", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  for (const char* key : {"psnr", "ssim", "num_gaussians", "per_view", "splits"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["training"]["finished"], true);
  EXPECT_EQ(work.read("out/run/log.jsonl").find(R"("event":"evaluation")"), std::string::npos)
      << "the views are scored once";
  EXPECT_EQ(json["export"]["frames"], 2);
  for (const char* file : {"run/model.ply", "run/metrics.json", "run/log.jsonl", "run/config.json",
                           "frames/frame_0000.ply", "frames/frame_0001.ply"})
    EXPECT_TRUE(fs::exists(work / "out" / file)) << file;
  if (!plays()) return;
  EXPECT_EQ(json["player"]["format"], "html");
  const std::string page = work.read("out/player/index.html");
  EXPECT_EQ(page.find(kPlayerConfig), std::string::npos);
  EXPECT_NE(page.find(R"("encoding":"base64")"), std::string::npos);
}

// Bugs put back, one at a time: `done` always false; the key of `train` without the options; the
// inputs of `ingest` without the files' stamps; products ignored. Each seen to fail.
TEST_F(CliRun, RepeatsOnlyWhatChanged) {
  const auto again = [&](const std::string& frames, const std::string& seed = "0") {
    return begun(run({"--export-frames", frames, "--seed", seed, "--overwrite"}));
  };
  ASSERT_EQ(again("2"), from("ingest"));
  EXPECT_EQ(again("2"), "");
  EXPECT_EQ(again("3"), "export report ") << "which links to the frames";
  EXPECT_EQ(again("3", "5"), from("ingest"));
  fs::remove(work / "out" / "run" / "metrics.json");
  EXPECT_EQ(again("3", "5"), "evaluate ");
  work.edit_json("capture/transforms_val.json",
                 [](nlohmann::json& json) { json["comment"] = "touched"; });
  EXPECT_EQ(again("3", "5"), from("ingest"));
}

// A copy that was cut off, and a model that was trained on. Bug put back: what is there counts as
// done; seen to fail.
TEST_F(CliRun, WhatIsNotAsItWasWrittenIsNoResult) {
  ASSERT_EQ(run().exit_code, 0);
  fs::resize_file(work / "out/run/metrics.json", 100);
  const ChildResult scored = run();
  EXPECT_EQ(begun(scored), "evaluate ") << scored.err;
  EXPECT_NE(scored.err.find("metrics.json is not what this run has written"), std::string::npos);
  if (plays()) {
    fs::resize_file(work / "out/player/index.html", 0);
    EXPECT_EQ(begun(run()), "page ");
  }
  EXPECT_EQ(begun(run()), "");
  const uintmax_t whole = fs::file_size(work / "out/run/model.ply");
  fs::resize_file(work / "out/run/model.ply", whole / 2);
  const ChildResult cut = run();
  EXPECT_EQ(cut.exit_code, 2) << cut.err;
  EXPECT_NE(cut.err.find("is not the model that this run has trained"), std::string::npos);
  EXPECT_EQ(fs::file_size(work / "out/run/model.ply"), whole / 2) << "nothing is lost";
  fs::remove(work / "out/run/model.ply");
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_EQ(fs::file_size(work / "out/run/model.ply"), whole);
}

// Bugs put back, each seen to fail: the backend and defaults that are spelt out taken for a change;
// numbers of enumerators recorded, not words; read-outs recorded only where there are some.
TEST_F(CliRun, ARefusalNamesWhatDiffers) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string model = work.read("out/run/model.ply");
  EXPECT_EQ(begun(run({"--backend", "cpu"})), "");
  const auto expect_refused = [&](const std::vector<std::string>& more, const std::string& change) {
    const ChildResult refused = run(more);
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_NE(refused.err.find("holds a finished run; changed: " + change), std::string::npos)
        << refused.err;
    EXPECT_NE(refused.err.find("--overwrite"), std::string::npos) << refused.err;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    EXPECT_TRUE(work.read("out/run/model.ply") == model);
  };
  expect_refused({"--seed", "9"}, "seed 1 → 9");
  expect_refused({"--preset", "3dgs"}, "preset balanced → 3dgs");
  expect_refused({"--scale", "0.5"}, "scale 1.0 → 0.5");
  expect_refused({"--cloud", "none"}, "cloud default → none");
  expect_refused({"--readout", "16ms,cam01=-8ms"}, "readout default → 0.016,cam01=-0.008");
}

// Bugs put back, each seen to fail: ingested again; the scene moved, so that the old run has none;
// a training that sweeps for the points that --cloud none leaves out.
TEST_F(CliRun, ARunThatReplacesOneTakesItsScene) {
  TESSERA_SKIP_WITHOUT_INGEST();
  const std::vector<std::string> ingested{"--cloud", "none", "--overwrite", "--export-frames", "2"};
  const auto with_seed = [&](const char* seed) {
    std::vector<std::string> more = ingested;
    more.insert(more.end(), {"--seed", seed});
    return run(more);
  };
  ASSERT_EQ(with_seed("1").exit_code, 0);
  ASSERT_TRUE(fs::exists(work / "out/scene/transforms.json"));
  EXPECT_EQ(nlohmann::json::parse(work.read("out/run/config.json"))["options"]["sweep"], false);
  const ChildResult again = with_seed("9");
  EXPECT_EQ(begun(again), from("train")) << again.err;
  EXPECT_TRUE(
      fs::equivalent(work / "out/scene/transforms.json", work / "out.1/scene/transforms.json"));
  EXPECT_EQ(begun(with_seed("9")), "");
}

// Finds: the places of the folder that was copied.
TEST_F(CliRun, ACopyPrintsItsOwnPlaces) {
  ASSERT_EQ(run({"--export-frames", "2"}).exit_code, 0);
  fs::copy(work / "out", work / "copy", fs::copy_options::recursive);
  std::vector<std::string> words =
      work.train_arguments("copy", {"--export-frames", "2", "--overwrite"});
  words[0] = "run";
  const ChildResult copied = work.run(words);
  EXPECT_EQ(begun(copied), "") << copied.err;
  EXPECT_EQ(copied.out.find(work.at("out")), std::string::npos) << copied.out;
  EXPECT_NE(copied.out.find(work.at("copy/frames")), std::string::npos) << copied.out;
}

// Bug put back: frames are written without --export-frames; seen to fail.
TEST_F(CliRun, WritesPlyFramesOnlyOnRequest) {
  const ChildResult result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(fs::exists(work / "out" / "frames"));
  EXPECT_EQ(nlohmann::json::parse(result.out)["export"]["frames"], 0);
  EXPECT_NE(run({"--export-frames", "2"}).out.find("(2 files, "), std::string::npos);
  const std::string stale = "holds the frames of an earlier run";
  EXPECT_NE(run().err.find(stale), std::string::npos);
  EXPECT_EQ(run({"--export-frames", "-1"}).exit_code, 2);
}

/// `text` has the parts in this order.
void expect_in_order(const std::string& text, const std::vector<std::string>& parts) {
  size_t from = 0;
  for (const std::string& part : parts) {
    const size_t found = text.find(part, from);
    EXPECT_NE(found, std::string::npos) << text << "lacks, or has too early, " << part;
    if (found != std::string::npos) from = found;
  }
}

TEST_F(CliRun, EndsWithScoresPlacesAndWhatToTypeNext) {
  const ChildResult result = run({"--verbose"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(run({"--json"}).out);
  const std::string out = work.at("out");
  expect_in_order(
      result.out,
      {fmt::format("test views (1): PSNR {:.2f} dB, SSIM", json["psnr"].get<double>()),
       "with zero padding", "LPIPS n/a",
       fmt::format("{} ({} static + {} dynamic)", json["num_gaussians"].get<int64_t>(),
                   json["num_static"].get<int64_t>(), json["num_dynamic"].get<int64_t>()),
       "Time ", "train ", "Sizes ", "model ", "Results", out + "/run/model.ply",
       out + "/run/metrics.json", "Next", "tessera render " + out + " --path ", "--mp4 -o " + out,
       "tessera export " + out + " --format ply -o " + out});
  if (plays())
    expect_in_order(result.out, {"player page ", "Results", out + "/player/index.html", "Next",
                                 "Open " + out + "/player/index.html in a web browser"});
  const ChildResult again = run();
  EXPECT_EQ(again.out.find("zero padding"), std::string::npos) << again.out;
  EXPECT_NE(again.out.find("all stages were done before"), std::string::npos) << again.out;
  const ChildResult quiet = run({"-q", "--seed", "7", "--overwrite"});
  EXPECT_EQ(std::count(quiet.err.begin(), quiet.err.end(), '\n'), plays() ? 0 : 1)
      << quiet.err << "but for the warning of a build that carries no page";
  EXPECT_NE(quiet.out.find("test views (1): PSNR"), std::string::npos) << quiet.out;
}

// Bug put back: a number's JSON text is cut after five characters; seen to fail.
TEST_F(CliRun, TrainRoundsThePsnrThatItPrints) {
  const ChildResult result = work.train("run", {"--evaluate-every", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream log(work.read("run/log.jsonl"));
  int lines = 0;
  for (std::string line; std::getline(log, line);) {
    const nlohmann::json event = nlohmann::json::parse(line);
    if (event["event"] != "evaluation") continue;
    const std::string said =
        fmt::format("step {}: test views: PSNR {:.2f} dB, ", event["iteration"].get<int64_t>(),
                    event["splits"]["test"]["psnr"].get<double>());
    EXPECT_NE(result.err.find(said), std::string::npos) << result.err << "lacks " << said;
    ++lines;
  }
  EXPECT_EQ(lines, 20);
}

// Finds: half of a file of ours is a foreign one, and the run is refused.
TEST_F(CliRun, WhatAKilledProgramLeftInThePlayerIsNoForeignFile) {
  work.write("out/player/.tessera_output.json.12-3.partial", "{");
  ASSERT_EQ(run().exit_code, 0);
  if (plays()) {
    EXPECT_FALSE(fs::exists(work / "out/player/.tessera_output.json.12-3.partial"));
  }
}

// Bug put back: a begun stage starts over instead of resuming; seen to fail.
TEST_F(CliRun, ResumesAStartedTraining) {
  ASSERT_EQ(run({"--checkpoint-every", "1"}).exit_code, 0);
  const std::string whole = work.read("out/run/model.ply");
  nlohmann::json stages = nlohmann::json::parse(work.read("out/stages.json"));
  stages["train"]["done"] = false;  // as a kill between the last checkpoint and the end leaves it
  work.write("out/stages.json", stages.dump());
  const ChildResult again = run({"--checkpoint-every", "1"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("initialised from checkpoint"), std::string::npos) << again.err;
  EXPECT_EQ(work.read("out/run/model.ply"), whole);
}

// Bug put back: an empty model is written without a word; seen to fail.
TEST(CliTrain, AModelWithoutGaussiansIsSaidToBeOne) {
  const CliWorkspace work;
  const std::string warning = "no Gaussians are left";
  EXPECT_EQ(work.train("some").err.find(warning), std::string::npos);
  const ChildResult none = work.train(
      "none", {"--prune-opacity", "1", "--densify-from", "0", "--densify-interval", "1"});
  EXPECT_EQ(none.exit_code, 0);
  EXPECT_NE(none.err.find(warning), std::string::npos) << none.err;
}

}  // namespace
}  // namespace tessera::testing
