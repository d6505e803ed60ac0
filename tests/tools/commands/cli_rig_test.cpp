// Rigs of videos through the whole program, where all layers share one address space.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

std::ptrdiff_t entries_of(const CliWorkspace& work) {
  return std::distance(std::filesystem::directory_iterator(work.path()), {});
}

// F14: this ended in SIGSEGV, in the program only: two structs of one name in two layers. Bug put
// back: PlayerCamera named RigCamera; seen to fail.
TEST(CliRig, AVideoWithoutAPose) {
  const CliWorkspace work;
  ASSERT_EQ(work.run({"synth", "room", "-o", work.at("rig"), "--layout", "videos", "--cameras", "4",
                      "--frames", "3", "--width", "64", "--height", "48", "--supersampling", "1",
                      "--points", "50"})
                .exit_code,
            0);
  json truth = json::parse(work.read("rig/ground_truth.json"));
  json& cameras = truth["cameras"];
  ASSERT_EQ(cameras.size(), 4u);
  cameras.erase(1);
  work.write("three.json", truth.dump());
  const std::ptrdiff_t before = entries_of(work);
  const std::vector<std::string> ingest{
      "ingest", work.at("rig"), "-o",  work.at("scene"), "--poses", work.at("three.json"), "--sync",
      "none",   "--cloud",      "none"};
  std::vector<std::string> strict = ingest;
  strict.emplace_back("--strict");
  work.expect_refused(strict, {"three.json: has no camera for cam01; it has cam00, cam02, cam03"});
  EXPECT_EQ(entries_of(work), before);
  const json report = work.run_json(ingest);
  EXPECT_EQ(report["cameras"], 3);
  EXPECT_NE(report["warnings"].dump().find("no camera for cam01"), std::string::npos);
}

/// A rendered rig of four cameras, with what `ingest` says of it.
json small_rig(const CliWorkspace& work, const std::vector<std::string>& more) {
  EXPECT_EQ(work.run({"synth",   "room",      "-o",       work.at("rig"), "--layout",
                      "n3dv",    "--cameras", "4",        "--frames",     "3",
                      "--width", "64",        "--height", "48",           "--supersampling",
                      "1",       "--points",  "50",       "--readout",    "cam01=0.4"})
                .exit_code,
            0);
  std::vector<std::string> ingest{"ingest", work.at("rig"), "-o",      work.at("scene"),
                                  "--sync", "none",         "--cloud", "none"};
  ingest.insert(ingest.end(), more.begin(), more.end());
  return work.run_json(ingest);
}

// Bug put back: what is stated of all cameras took precedence; seen to fail.
TEST(CliRig, ReadoutsAreStatedForAllCamerasOrSome) {
  const CliWorkspace work;
  small_rig(work, {"--readout", "-8ms,cam01=0.016"});
  const json scene = json::parse(work.read("scene/transforms.json"));
  for (const json& frame : scene["frames"]) {
    const bool is_named = frame["tessera"]["camera"] == "cam01";
    EXPECT_NEAR(frame["readout"].get<double>(), is_named ? 0.016 : -0.008, 1e-12);
  }
  const std::vector<std::string> ingest{"ingest", work.at("rig"), "-o", work.at("other"),
                                        "--readout"};
  const auto expect_refused = [&](const char* value, const std::string& reason) {
    std::vector<std::string> command = ingest;
    command.emplace_back(value);
    work.expect_refused(command, {reason});
  };
  expect_refused("cam09=5ms", "--readout names cam09, but the cameras are cam00");
  expect_refused("16min", "give a time up to a second like 16ms");
  expect_refused("16", "give a time up to a second like 16ms");
}

// Bug put back: `evaluate` drew all rows at one time; seen to fail.
TEST(CliRig, ViewsOfRollingShuttersAreScoredByTheTimesOfTheirRows) {
  const CliWorkspace work;
  small_rig(work, {"--readout", "30ms"});
  const json trained = work.run_json({"train", work.at("scene"), "-o", work.at("out"), "--backend",
                                      "cpu", "--iterations", "20", "--init-points", "300"});
  ASSERT_GT(trained["num_dynamic"], 0);
  const json scores = work.run_json({"evaluate", work.at("out"), "--split", "test"});
  EXPECT_NEAR(scores["psnr"].get<double>(), trained["scores"]["psnr"].get<double>(), 1e-6);
}

TEST(CliRig, ClocksThatWereMeasuredAreLearnt) {
  const CliWorkspace work;
  small_rig(work, {});
  const auto learnt = [&](const char* source, double offset, const char* clocks) {
    json scene = json::parse(work.read("scene/transforms.json"));
    json& camera = scene["tessera"]["cameras"][1];
    camera["time_offset_source"] = source;
    camera["time_offset"] = offset;
    work.write("scene/transforms.json", scene.dump());
    return work
        .run_json({"train", work.at("scene"), "-o", work.at("out"), "--overwrite", "--backend",
                   "cpu", "--iterations", "2", "--init-points", "100", "--clocks",
                   clocks})["clocks"]
        .size();
  };
  EXPECT_EQ(learnt("motion", 0.01, "auto"), 3u);
  EXPECT_EQ(learnt("audio", 0.01, "auto"), 3u);
  EXPECT_EQ(learnt("motion", 0, "auto"), 0u);
  EXPECT_EQ(learnt("stated", 0.01, "auto"), 0u);
  EXPECT_EQ(learnt("motion", 0.01, "fixed"), 0u);
}

// Bug put back: `run` checked the folder without the options of ingest; seen to fail.
TEST(CliRig, RunTakesWhatDecidesBetweenRigAndPhotos) {
  const CliWorkspace work;
  for (const char* camera : {"kitchen0x", "kitchen1x"})
    for (int number = 0; number < 9; ++number)
      work.write(fmt::format("rig/{}/{:04}.png", camera, number), "no PNG");
  const std::vector<std::string> plain{"run", work.at("rig"), "-o", work.at("out")};
  work.expect_refused(plain, {"--layout rig", "--layout photos"});
  const auto expect_read = [&](const std::vector<std::string>& more, const std::string& reason) {
    std::vector<std::string> command = plain;
    command.insert(command.end(), more.begin(), more.end());
    const ChildResult result = work.run(command);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("[1/6] ingest\n"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(reason), std::string::npos) << result.err;
  };
  expect_read({"--layout", "rig"}, "kitchen0x/0000.png: is not a PNG");
  work.write("cameras.json", "{}");
  expect_read({"--poses", work.at("cameras.json")}, "cameras.json: has no list");
}

}  // namespace
}  // namespace tessera::testing
