// `tessera doctor` as a program: exit codes, one JSON object, and no remaining files.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

// Fails with the exit code not asking for errors, and with the sample written beside the capture.
TEST(CliDoctor, ExitCodesAndJson) {
  const CliWorkspace work;
  const json report = work.run_json({"doctor", work.at("capture")});  // exit code 0
  EXPECT_EQ(report["errors"], 0);
  for (const char* table :
       {"poses", "exposure", "blur", "coverage", "cloud", "time", "forecast", "leakage"})
    EXPECT_TRUE(report["tables"].contains(table)) << table;
  for (const json& finding : report["findings"])
    for (const char* key : {"severity", "check", "camera", "measured", "advice"})
      EXPECT_TRUE(finding.contains(key)) << finding;

  std::filesystem::copy_file(work / "capture/train/r_000.png", work / "capture/test/r_000.png",
                             std::filesystem::copy_options::overwrite_existing);
  const ChildResult leaky = work.run({"doctor", work.at("capture")});
  EXPECT_EQ(leaky.exit_code, 1) << leaky.err;
  EXPECT_TRUE(leaky.out.starts_with("error    leakage ")) << leaky.out;
  work.expect_refused({"doctor", work.at("nowhere")}, {"nowhere", "no such folder"});
  work.expect_refused({"ingest", work.at("capture"), "-o", work.at("scene"), "--fit-exposure"},
                      {"--fit-exposure", "leave it out"});
  EXPECT_FALSE(std::filesystem::exists(work / "scene"));
}

}  // namespace
}  // namespace tessera::testing
