// `train` on a scene without a cloud: the plane sweep before it, and the option that turns it off.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "ingest/files/png.h"
#include "ingest/prepared/prepared_scene.h"
#include "tests/ingest/cloud/wall_scene.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

/// A prepared scene without points.ply below `folder`.
void write_wall(const std::filesystem::path& folder,
                const WallRig& rig = {.cameras = 4, .size = 40}) {
  Capture prepared;
  for (const Frame& frame : wall_scene(rig).frames) {
    write_png(folder / (frame.name + ".png"), frame.image);
    CaptureFrame& written = prepared.frames.emplace_back();
    written.file_path = frame.name + ".png";
    written.frame = frame;
  }
  write_prepared_scene(folder, prepared);
}

/// The report of `train` on the scene in folder `scene`.
std::string trained(const CliWorkspace& work, const std::string& scene, const std::string& run,
                    const std::string& sweep) {
  std::vector<std::string> arguments =
      work.train_arguments(run, {"--iterations", "2", "--sweep", sweep, "--init-points", "300"});
  arguments[1] = work.at(scene);
  const ChildResult result = work.run(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result.err;
}

// Bugs that fail it: complete_cloud not called ("on"); options.sweep ignored ("off").
TEST(CliSweep, CompletesAScene) {
  const CliWorkspace work;
  write_wall(work / "wall");
  const std::string reported = trained(work, "wall", "on", "true");
  const std::regex sweep(
      "plane sweep: ([0-9]+) points in [^;]* of static things at 2 timesteps and of moving ones at "
      "2; "
      "([0-9]+) points move");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(reported, found, sweep)) << reported;
  EXPECT_GT(std::stoi(found[1]), 500);
  EXPECT_GT(std::stoi(found[2]), 50);
  const std::string source = "point cloud, 300 of " + found[1].str() + " points, and 30 at random";
  EXPECT_NE(reported.find(source), std::string::npos) << reported;
  EXPECT_EQ(trained(work, "wall", "off", "false").find("point cloud"), std::string::npos);
}

// Bug put back: the cloud counted among what a resumed training must find again; seen to fail.
TEST(CliSweep, ATrainingThatMadeItsCloudResumes) {
  const CliWorkspace work;
  write_wall(work / "wall");
  const auto train = [&](const std::string& run, const std::vector<std::string>& more) {
    std::vector<std::string> words{"--iterations", "6", "--init-points", "300", "--deterministic"};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<std::string> arguments = work.train_arguments(run, words);
    arguments[1] = work.at("wall");
    const ChildResult result = work.run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  train("whole", {});
  train("parts", {"--stop-after", "3"});
  const std::string resumed = train("parts", {});
  EXPECT_EQ(resumed.find("was trained on other frames"), std::string::npos) << resumed;
  EXPECT_NE(resumed.find("initialised from checkpoint"), std::string::npos) << resumed;
  EXPECT_EQ(work.read("parts/model.ply"), work.read("whole/model.ply"));
}

// Bug that fails it: complete_cloud sweeps the frames of the training.
TEST(CliSweep, StartsFromTheCloudThatIngestMakes) {
  TESSERA_SKIP_WITHOUT_INGEST();
  const CliWorkspace work;
  write_wall(work / "wall");
  const ChildResult ingested = work.run({"ingest", work.at("wall"), "-o", work.at("ingested")});
  ASSERT_EQ(ingested.exit_code, 0) << ingested.err;
  EXPECT_EQ(trained(work, "ingested", "after", "true").find("plane sweep"), std::string::npos);
  trained(work, "wall", "directly", "true");
  EXPECT_EQ(work.read("directly/model.ply"), work.read("after/model.ply"));
}

/// The wall at 0.8 of its levels, and at 0.6 of camera 1.
std::array<uint8_t, 3> dimmed_wall(int camera, double x, double y, double time) {
  std::array<uint8_t, 3> colour = wall_colour(x, y, time);
  for (uint8_t& level : colour) level = uint8_t((camera == 1 ? 0.6 : 0.8) * level);
  return colour;
}

/// config.json's options after a step of `fast` on a scene of `work`.
nlohmann::json options_on(const CliWorkspace& work, const std::string& scene,
                          const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"--iterations", "1", "--preset", "fast", "--overwrite"};
  words.insert(words.end(), more.begin(), more.end());
  std::vector<std::string> arguments = work.train_arguments("run", words);
  arguments[1] = work.at(scene);
  const ChildResult result = work.run(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(work.read("run/config.json"))["options"];
}

// The near plane: Gaussians between the cameras and the wall show in no training image, but in
// those of others. Bugs put back, each seen to fail: auto always camera; auto always none; the
// depth in place of half of it; the near plane of a user replaced, too.
TEST(CliSweep, ExposureAndNearPlaneFollowTheScene) {
  const CliWorkspace work;
  write_wall(work / "even", {.cameras = 4, .timesteps = 3, .size = 64});
  write_wall(work / "uneven", {.cameras = 4, .timesteps = 3, .size = 64, .colour = dimmed_wall});
  const nlohmann::json even = options_on(work, "even");
  EXPECT_EQ(even["exposure"], "none") << "a rig, whose cameras are equal";
  EXPECT_GT(even["near_plane"], 0.4 * kWallDepth);
  EXPECT_LT(even["near_plane"], 0.5 * kWallDepth);
  const nlohmann::json uneven = options_on(work, "uneven", {"--near-plane", "0.25"});
  EXPECT_EQ(uneven["exposure"], "camera");
  EXPECT_EQ(uneven["near_plane"], 0.25);
  EXPECT_EQ(options_on(work, "uneven", {"--exposure", "none"})["exposure"], "none");
}

// Bug put back: gains written whatever is learnt; seen to fail.
TEST(CliSweep, AffineColoursOfCamerasAreInAFile) {
  const CliWorkspace work;
  write_wall(work / "uneven", {.cameras = 4, .timesteps = 3, .size = 64, .colour = dimmed_wall});
  EXPECT_EQ(options_on(work, "uneven", {"--exposure", "affine", "--sweep", "false"})["exposure"],
            "affine");
  const auto exposure = nlohmann::json::parse(work.read("run/exposure.json"));
  EXPECT_EQ(exposure["by"], "affine");
  EXPECT_GE(exposure["maps"].size(), 3u) << "one of four cameras may be for tests";
  for (const auto& [camera, map] : exposure["maps"].items()) {
    EXPECT_EQ(map["matrix"].size(), 3u) << camera;
    EXPECT_EQ(map["matrix"][0].size(), 3u) << camera;
    EXPECT_EQ(map["offset"].size(), 3u) << camera;
  }
}

}  // namespace
}  // namespace tessera::testing
