// Images and files written by `render` and `export`: they agree with each other and replace older
// results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

int largest_difference(const Image8& a, const Image8& b) {
  EXPECT_EQ(a.data.size(), b.data.size());
  int largest = 0;
  for (size_t i = 0; i < std::min(a.data.size(), b.data.size()); ++i)
    largest = std::max(largest, std::abs(int(a.data[i]) - int(b.data[i])));
  return largest;
}

class CliImage : public ::testing::Test {
 protected:
  /// Without the filter, which frames in the 3DGS format do not have.
  void SetUp() override { ASSERT_EQ(work.train("run", {"--no-filter-2d"}).exit_code, 0); }
  /// The single image of the test split.
  Image8 render(const std::string& model, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"render",  work.at(model), "--cameras", work.at("capture"),
                                       "--split", "test",         "-o",        work.at("pictures")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = work.run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_png(work / "pictures/test/r_000.png");
  }
  CliWorkspace work;
};

// Seen to fail with the slice leaving out the temporal factor of opacity.
TEST_F(CliImage, AnExportedFrameRendersLikeTheModel) {
  const Image8 model = render("run", {"--time", "0.3"});
  ASSERT_EQ(work.run({"export", work.at("run"), "-o", work.at("frame"), "--time", "0.3"}).exit_code,
            0);
  const Image8 frame = render("frame/frame_0000.ply");
  EXPECT_LE(largest_difference(model, frame), 1);
  EXPECT_GT(largest_difference(model, Image8{32, 32, 3, std::vector<uint8_t>(32 * 32 * 3)}), 20);
}

// Seen to fail with premultiplied colour in the PNG.
TEST_F(CliImage, AlphaCompositesToTheOpaqueImage) {
  const Image8 opaque = render("run", {"--background", "200,100,50"});
  const Image8 straight = render("run", {"--alpha"});
  ASSERT_EQ(straight.channels, 4);
  EXPECT_LE(largest_difference(opaque, composite_on(straight, {200, 100, 50})), 2);
}

// Seen to fail with rows of the .pfm from top to bottom.
TEST_F(CliImage, FloatsRoundToThePng) {
  const Image8 png = render("run", {"--float"});
  const std::string pfm = work.read("pictures/test/r_000.pfm"), head = "PF\n32 32\n-1.0\n";
  ASSERT_EQ(pfm.substr(0, head.size()), head);
  ASSERT_EQ(pfm.size(), head.size() + 32 * 32 * 3 * sizeof(float));
  for (size_t row = 0; row < 32; ++row)
    for (size_t i = 0; i < 32 * 3; ++i) {
      float value = 0;
      std::memcpy(&value, pfm.data() + head.size() + ((31 - row) * 32 * 3 + i) * sizeof(float),
                  sizeof(float));
      EXPECT_EQ(png.data[row * 32 * 3 + i],
                uint8_t(std::floor(std::min(1.0f, std::max(0.0f, value)) * 255 + 0.5f)));
    }
}

// Seen to fail with find_image called for camera paths too.
TEST_F(CliImage, ACameraPathNeedsNoImages) {
  fs::create_directories(work / "path");
  fs::copy(work / "capture/transforms_test.json", work / "path/cameras.json");
  work.edit_json("path/cameras.json", [](json& file) {
    file["frames"][0].erase("file_path");
    file["frames"][0]["time"] = 0.3;
  });
  const json rendered = work.run_json({"render", work.at("run"), "--cameras",
                                       work.at("path/cameras.json"), "-o", work.at("along")});
  ASSERT_EQ(rendered["frames"].size(), 1u);
  EXPECT_EQ(rendered["frames"][0]["time"], 0.3);
  EXPECT_EQ(largest_difference(read_png(work / "along/0000.png"), render("run", {"--time", "0.3"})),
            0);
  work.edit_json("path/cameras.json", [](json& file) { file["frames"][0].erase("time"); });
  work.expect_refused(
      {"render", work.at("run"), "--cameras", work.at("path/cameras.json"), "-o", work.at("along")},
      {"frame 0", "no time", "--time"});
}

// Seen to fail with the listed files of an earlier run left in place.
TEST_F(CliImage, ALongerEarlierExportLeavesNoFrames) {
  const auto export_frames = [&](const char* frames) {
    return work.run({"export", work.at("run"), "-o", work.at("out"), "--frames", frames}).exit_code;
  };
  ASSERT_EQ(export_frames("4"), 0);
  work.write("out/notes.txt", "kept");
  ASSERT_EQ(export_frames("2"), 0);
  EXPECT_TRUE(fs::exists(work / "out/frame_0001.ply"));
  EXPECT_FALSE(fs::exists(work / "out/frame_0002.ply"));
  ASSERT_EQ(
      work.run({"export", work.at("run"), "-o", work.at("out"), "--format", "model"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(work / "out/frame_0000.ply"));
  EXPECT_EQ(work.read("out/model.ply"), work.read("run/model.ply"));
  EXPECT_EQ(work.read("out/notes.txt"), "kept");
  work.expect_refused({"export", work.at("out/model.ply"), "-o", work.at("out")},
                      {"folder of the model itself"});
}

}  // namespace
}  // namespace tessera::testing
