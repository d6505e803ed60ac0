// A video without motion gives a model without dynamic Gaussians, against the same training with
// this stated; also with sensor noise and with an exposure that changes from frame to frame.
// Source: failure mode A6.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kFrames = "30";

/// The result of a training of the room.
struct Trained {
  json scores;
  int64_t bytes = 0;           // of the exported Tessera 4D file
  std::vector<Image8> images;  // of the held-out camera, by timestep
};

class NullCase : public ::testing::Test {
 protected:
  /// Films and prepares the room as it stands.
  void film(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"synth",     "room-static", "-o",       work.at("room"),
                                       "--layout",  "n3dv",        "--frames", kFrames,
                                       "--cameras", "6",           "--width",  "96",
                                       "--height",  "72",          "--points", "50"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_EQ(work.run(arguments).exit_code, 0);
    ASSERT_EQ(
        work.run({"ingest", work.at("room"), "-o", work.at("scene"), "--sync", "none"}).exit_code,
        0);
  }
  Trained train(const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"train",
                                       work.at("scene"),
                                       "-o",
                                       work.at(name),
                                       "--preset",
                                       "fast",
                                       "--iterations",
                                       "200",
                                       "--decide-motion",
                                       "true",
                                       "--size",
                                       "knee",
                                       "--decide-colour",
                                       "true",
                                       "--decide-interval",
                                       "5000",
                                       "--near-plane",  // that of rigs is another
                                       "0.2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = work.run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    Trained trained;
    trained.scores = work.run_json({"evaluate", work.at(name), "--split", "test"});
    work.run({"export", work.at(name), "-o", work.at(name + "_file"), "--format", "tessera"});
    for (const auto& entry : fs::recursive_directory_iterator(work / (name + "_file")))
      if (entry.path().extension() != ".json") trained.bytes += int64_t(entry.file_size());
    work.run({"render", work.at(name), "--cameras", work.at("scene"), "--split", "test", "-o",
              work.at(name + "_pictures")});
    for (const auto& entry : fs::recursive_directory_iterator(work / (name + "_pictures")))
      if (entry.path().extension() == ".png") trained.images.push_back(read_png(entry.path()));
    return trained;
  }
  /// The whole row of A6.
  void expect_as_told(const std::vector<std::string>& more) {
    const Trained found = train("found", more);
    // the options of that one: presets have others where nothing is said to move
    std::vector<std::string> told = more;
    told.insert(told.end(), {"--config", work.at("found/config.json"), "--motion", "none"});
    const Trained given = train("given", told);
    int changed = 0;
    EXPECT_EQ(found.scores["num_dynamic"], 0);
    EXPECT_LE(double(found.bytes), 1.05 * double(given.bytes));
    EXPECT_GE(double(found.scores["psnr"]), double(given.scores["psnr"]) - 0.05);
    ASSERT_EQ(found.images.size(), size_t(std::stoi(kFrames)));
    for (const Image8& image : found.images) changed += image.data != found.images.front().data;
    EXPECT_EQ(changed, 0) << "timesteps that look different from the first";
    ASSERT_GT(given.bytes, 0);
  }
  CliWorkspace work;
};

TEST_F(NullCase, OfAStaticVideo) {
  film({});
  expect_as_told({});
}

TEST_F(NullCase, OfAStaticVideoWithNoise) {
  film({"--noise", "2"});
  expect_as_told({});
}

TEST_F(NullCase, OfAStaticVideoWhoseExposureChanges) {
  film({"--exposure-wobble", "0.01"});
  expect_as_told({"--exposure", "frame"});
}

}  // namespace
}  // namespace tessera::testing
