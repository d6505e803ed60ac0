// Ctrl-C during render, export and synth: exit code 130, complete files only, and the same command
// succeeds afterwards. Training is tested in cli_resume_test.cpp.
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

void expect_no_partial_files(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
}

// Seen to fail with SIGINT left to its default.
TEST(CliInterrupt, RenderStopsBetweenImages) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  work.edit_json("capture/transforms_test.json", [](nlohmann::json& file) {
    const nlohmann::json frame = file["frames"][0];
    for (int i = 0; i < 3000; ++i) {
      file["frames"].push_back(frame);
      file["frames"].back()["file_path"] = "./f" + std::to_string(i);
    }
  });
  const std::vector<std::string> arguments{"render",    work.at("run"),
                                           "--cameras", work.at("capture/transforms_test.json"),
                                           "-o",        work.at("out")};
  ChildProcess rendering(arguments, work.path());
  const auto begun = [&] {
    std::error_code absent;
    for (const auto& entry : fs::recursive_directory_iterator(work / "out", absent))
      if (entry.path().filename() == "f5.png") return true;
    return false;
  };
  ASSERT_TRUE(rendering.wait_until(begun));
  rendering.send(SIGINT);
  const ChildResult stopped = rendering.wait();
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_EQ(stopped.out, "");
  EXPECT_FALSE(fs::exists(work / "out")) << "all of it or nothing";

  work.edit_json("capture/transforms_test.json", [](nlohmann::json& file) {
    file["frames"] = nlohmann::json::array({file["frames"][0]});
  });
  EXPECT_EQ(work.run(arguments).exit_code, 0);
  expect_no_partial_files(work / "out");
}

// Seen to fail with SIGINT left to its default.
TEST(CliInterrupt, SynthLeavesNothing) {
  const CliWorkspace work;
  const auto started = [&] {
    for (const auto& entry : fs::directory_iterator(work.path()))
      if (entry.path().filename().string().find(".big.") == 0) return true;
    return false;
  };
  ChildProcess making({"synth", "object", "-o", work.at("big"), "--layout", "dnerf", "--frames",
                       "5000", "--width", "48", "--height", "48"},
                      work.path());
  ASSERT_TRUE(making.wait_until(started));
  making.send(SIGINT);
  EXPECT_EQ(making.wait().exit_code, 130);
  EXPECT_FALSE(fs::exists(work / "big"));
  EXPECT_FALSE(started());
}

}  // namespace
}  // namespace tessera::testing
