// The size requested on the command line (Gaussians, bytes, decibels) is the size of the exported
// model. Source: failure mode C13.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

class CliContract : public ::testing::Test {
 protected:
  CliContract() { work.film_object("six", 6, 32); }
  json train(const std::string& run, const std::vector<std::string>& more) const {
    // clang-format off
    std::vector<std::string> arguments{
        "train", work.at("six"), "-o", work.at(run), "--preset", "fast", "--iterations", "40",
        "--schedule-iterations", "40", "--init-points", "300", "--batch", "2", "--sweep", "false",
        "--densify-until", "15", "--thin-until", "30", "--decide-interval", "8"};
    // clang-format on
    arguments.insert(arguments.end(), more.begin(), more.end());
    return work.run_json(arguments);
  }
  CliWorkspace work;
};

TEST_F(CliContract, SoManyGaussians) {
  for (const int64_t asked : {50, 7}) {
    const std::string run = std::to_string(asked);
    const json trained = train(run, {"--max-gaussians", run});
    EXPECT_EQ(trained["num_gaussians"], asked);
    EXPECT_EQ(work.run_json({"info", work.at(run)})["num_gaussians"], asked);
  }
}

TEST_F(CliContract, SoManyBytes) {
  constexpr int64_t kAsked = 8000;  // 2.7 kB of it are the cameras
  EXPECT_GT(train("run", {"--max-bytes", std::to_string(kAsked)})["num_gaussians"], 0);
  work.run_json(
      {"export", work.at("run"), "-o", work.at("shipped"), "--format", "tessera", "--single"});
  const auto bytes = int64_t(std::filesystem::file_size(work / "shipped" / "scene.t4d"));
  EXPECT_LE(bytes, kAsked);
  constexpr int64_t kBlock = 300;  // what a Gaussian that opens a block adds to the manifest
  EXPECT_GT(bytes, kAsked - kBlock) << "one Gaussian more would not fit";
}

// Bugs put back: the limit looked at after the training alone, in each of both commands; any number
// of bytes taken; each seen to fail.
TEST_F(CliContract, BytesThatNoModelFitsIntoAreRefusedFirst) {
  for (const char* const command : {"train", "run"}) {
    const std::string out = work.at(std::string("out_") + command);
    const auto with = [&](const char* bytes) {
      return std::vector<std::string>{command,     work.at("six"), "-o",           out,
                                      "--preset",  "fast",         "--max-bytes",  bytes,
                                      "--backend", "cpu",          "--iterations", "3"};
    };
    work.expect_refused(with("5"), {"--max-bytes 5", "5 bytes", "5MB?"});
    EXPECT_FALSE(std::filesystem::exists(out)) << command;
    const ChildResult refused = work.run(with("1kB"));
    EXPECT_EQ(refused.exit_code, 2) << command;
    for (const char* part : {"--max-bytes 1000", "camera poses", "pass more"})
      EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(out + "/run")) << command;
    EXPECT_FALSE(std::filesystem::exists(out + "/config.json")) << command;
  }
}

TEST_F(CliContract, WithinSoManyDecibels) {
  const json trained = train("run", {"--within-db", "0.5", "--validate-interval", "5"});
  EXPECT_EQ(trained["validation"]["frames"], 1) << "of six";
  const double peak = trained["validation"]["peak_psnr"];
  EXPECT_GE(double(trained["validation"]["best_psnr"]), peak - 0.5);
  EXPECT_LE(int64_t(trained["num_gaussians"]), int64_t(trained["validation"]["best_gaussians"]));
  const json config = json::parse(work.read("run/config.json"));
  EXPECT_GT(double(config["options"]["validation_share"]), 0);
}

TEST_F(CliContract, OneOfThem) {
  work.expect_refused(
      {"train", work.at("six"), "-o", work.at("run"), "--max-gaussians", "9", "--within-db", "1"},
      {"max_gaussians, max_bytes and within_db", "pass one"});
}

}  // namespace
}  // namespace tessera::testing
