// A clip that is trained in two windows, for tests of commands about windows.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {

/// A room that four cameras film for two seconds, 24 frames each.
class CliWindows : public ::testing::Test {
 protected:
  void SetUp() override {
    const ChildResult made =
        work.run({"synth", "room", "-o", work.at("room"), "--layout", "n3dv", "--cameras", "4",
                  "--frames", "48", "--width", "48", "--height", "36", "--supersampling", "1"});
    if (made.exit_code != 0) GTEST_SKIP() << "no video encoder: " << made.err;
    ASSERT_EQ(work.run({"ingest", work.at("room"), "-o", work.at("scene"), "--cloud", "none",
                        "--frames-as", "video"})
                  .exit_code,
              0);
  }
  /// `command` with the options of a tiny training, and more.
  static std::vector<std::string> tiny(std::vector<std::string> command,
                                       const std::vector<std::string>& more) {
    std::istringstream options(
        "--backend cpu --threads 2 --batch 1 --init-points 300 --sweep false");
    command.insert(command.end(), std::istream_iterator<std::string>(options), {});
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  std::vector<std::string> train(const std::string& out, std::vector<std::string> more = {}) const {
    if (std::find(more.begin(), more.end(), "--iterations") == more.end())
      more.insert(more.end(), {"--iterations", "12"});
    return tiny({"train", work.at("scene"), "-o", work.at(out), "--windows", "1s"}, more);
  }
  const CliWorkspace work;
};

}  // namespace tessera::testing
