// `train` chooses between motion nodes and dynamic Gaussians for a single camera and states the
// reason; a training that is stopped before the choice makes it after the resume.
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

class CliMotion : public ::testing::Test {
 protected:
  CliMotion() { work.film_object("film", 26, 16); }
  std::vector<std::string> training(const std::string& run, const std::string& steps,
                                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"train",   work.at("film"), "-o",           work.at(run),
                                       "--sweep", "false",         "--iterations", steps};
    for (const char* word : {"--init-points", "60", "--peak-gaussians", "80"})
      arguments.push_back(word);
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  json options_of(const std::string& run) const {
    return json::parse(read_text_file(work / (run + "/config.json")))["options"];
  }

  CliWorkspace work;
};

// Bugs put back: a wrong choice kept after the stop; the options of nodes forgotten by the
// checkpoint; each seen to fail.
TEST_F(CliMotion, AStopBeforeTheChoiceLosesNothing) {
  // each writes into a folder of its own, so that no line is taken for the other's
  const auto stop_in_trial = [&](const char* output, const std::vector<std::string>& arguments) {
    std::filesystem::create_directory(work / output);
    ChildProcess stopped(arguments, work / output);
    EXPECT_TRUE(stopped.wait_until(
        [&] { return stopped.err_so_far().find("short trainings say") != std::string::npos; }));
    stopped.send(SIGINT);
    EXPECT_EQ(stopped.wait().exit_code, 130);
    EXPECT_EQ(options_of("run")["motion"], "auto");
  };
  stop_in_trial("first", training("run", "4000", {"--preset", "best"}));
  stop_in_trial("second", {"train", work.at("film"), "-o", work.at("run"), "--resume"});
  const json config = json::parse(read_text_file(work / "run/config.json"));
  EXPECT_EQ(config["with_nodes"]["densification"], "budget")
      << "the first command's, after a resume";

  const ChildResult resumed =
      work.run({"train", work.at("film"), "-o", work.at("run"), "--resume", "--stop-after", "2"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_NE(resumed.err.find("frames held out have"), std::string::npos) << resumed.err;
  const json options = options_of("run");
  const bool nodes = resumed.err.find("nodes carry the scene") != std::string::npos;
  EXPECT_EQ(options["motion"], nodes ? "nodes" : "pair");
  EXPECT_EQ(options["densification"], nodes ? "budget" : "mcmc") << "best's own for each";
  EXPECT_EQ(options["peak_gaussians"], 80) << "what was typed goes over the preset";
}

// Bug put back: the trial made whatever is typed; seen to fail.
TEST_F(CliMotion, WhatIsTypedIsDone) {
  const ChildResult typed =
      work.run(training("typed", "4000", {"--motion", "nodes", "--stop-after", "2"}));
  ASSERT_EQ(typed.exit_code, 0) << typed.err;
  EXPECT_EQ(typed.err.find("motion:"), std::string::npos) << typed.err;
  EXPECT_EQ(options_of("typed")["motion"], "nodes");
  EXPECT_GT(options_of("typed")["min_blending_weight"], 0) << "the preset's, for nodes";

  const ChildResult brief = work.run(training("brief", "8"));
  ASSERT_EQ(brief.exit_code, 0) << brief.err;
  EXPECT_NE(brief.err.find("a training of 8 steps is short beside a trial"), std::string::npos)
      << brief.err;
  EXPECT_EQ(options_of("brief")["motion"], "pair");
}

// Bug put back: --time-limit not asked during a trial; seen to fail.
TEST_F(CliMotion, ATrialTakesAQuarterOfATimeLimit) {
  work.film_object("wide", 26, 128);
  const ChildResult result =
      work.run({"train", work.at("wide"), "-o", work.at("run"), "--time-limit", "6s"});
  EXPECT_EQ(result.exit_code, 75) << result.err;
  EXPECT_NE(result.err.find("--time-limit leaves too little time"), std::string::npos)
      << result.err;
  EXPECT_EQ(options_of("run")["motion"], "pair");
}

}  // namespace
}  // namespace tessera::testing
