// What: `train` on a scene without a cloud: the sweep before it, and the switch of the sweep.
// Not: the points it finds (tests/ingest/cloud/dense_cloud_test.cpp).
#include <gtest/gtest.h>

#include <regex>

#include "ingest/files/png.h"
#include "ingest/layouts/prepared_scene.h"
#include "tests/ingest/cloud/wall_scene.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

/// A prepared scene without points.ply below `folder`.
void write_wall(const std::filesystem::path& folder) {
  PreparedScene prepared;
  for (const Frame& frame : wall_scene({.cameras = 4, .size = 40}).frames) {
    write_png(folder / (frame.name + ".png"), frame.image);
    prepared.frames.push_back({frame.name + ".png", frame, {}, {}});
  }
  write_prepared_scene(folder, prepared);
}

// Bugs that fail it: complete_cloud not called ("on"); options.sweep not looked at ("off").
TEST(CliSweep, CompletesAScene) {
  const CliWorkspace work;
  write_wall(work / "wall");
  const auto initialised = [&](const std::string& run, const std::string& sweep) {
    std::vector<std::string> arguments =
        work.train_arguments(run, {"--iterations", "2", "--sweep", sweep, "--init-points", "60"});
    arguments[1] = work.at("wall");
    const ChildResult result = work.run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  const std::string said = initialised("on", "true");
  const std::regex cloud("point cloud, ([0-9]+) of \\1 points, and [0-9]+ at random");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(said, found, cloud)) << said;
  EXPECT_GE(std::stoi(found[1]), 50);  // of 60 that were asked for; near ones are one point
  EXPECT_LE(std::stoi(found[1]), 60);
  EXPECT_NE(initialised("off", "false").find("random, "), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing
