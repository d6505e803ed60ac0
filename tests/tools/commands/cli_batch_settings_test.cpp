// The settings that `tessera batch` writes into batch.yaml for captures of several kinds.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// With a program in the engine's place that ends at once.
ChildResult run_without_engine(const CliWorkspace& work,
                               const std::vector<std::string>& arguments) {
  fs::create_directory(work / "bin");
  work.write("bin/snakemake", "#!/bin/sh\nexit 1\n");
  fs::permissions(work / "bin/snakemake", fs::perms::owner_all);
  const char* const found = std::getenv("PATH");
  const std::string before = found != nullptr ? found : "";
  ::setenv("PATH", (work.at("bin") + ":" + before).c_str(), 1);
  const ChildResult result = work.run(arguments);
  ::setenv("PATH", before.c_str(), 1);
  return result;
}

// Bug put back: the option given to every capture, so that rigs and captures with test frames fail;
// seen to fail.
TEST(CliBatchSettings, TestEveryIsGivenWhereItApplies) {
  const CliWorkspace work;
  fs::create_directory(work / "all");
  fs::copy(work / "capture", work / "all/stated", fs::copy_options::recursive);
  fs::create_directories(work / "all/photos");
  fs::copy(work / "capture/train", work / "all/photos/train");
  fs::copy(work / "capture/transforms_train.json", work / "all/photos/transforms_train.json");
  fs::create_directories(work / "all/rig");
  work.write("all/rig/cam00.mp4", "");
  work.write("all/rig/cam01.mp4", "");
  const ChildResult result = run_without_engine(
      work, {"batch", work.at("all"), "-o", work.at("out"), "--test-every", "2"});
  EXPECT_NE(result.err.find("--test-every is passed over for rig, stated"), std::string::npos)
      << result.err;
  const json yaml = json::parse(work.read("out/batch.yaml"));
  ASSERT_EQ(yaml["scenes"].size(), 3u);
  for (const json& scene : yaml["scenes"])
    EXPECT_EQ(scene["ingest"],
              scene["name"] == "photos" ? json({"--test-every", "2"}) : json::array())
        << scene.dump();
}

}  // namespace
}  // namespace tessera::testing
