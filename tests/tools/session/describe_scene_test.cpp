// Cameras, frames and reading of image sequences, as `tessera info` describes them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/support/scratch_folder.h"
#include "tools/commands/describe.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

/// Twenty empty images 000000.png … in each folder.
void write_names(const std::filesystem::path& folder, const std::vector<std::string>& cameras) {
  for (const std::string& camera : cameras) {
    std::filesystem::create_directories(folder / camera);
    for (int n = 0; n < 20; ++n) std::ofstream(folder / camera / fmt::format("{:06}.png", n));
  }
}

// `info` reported of such a folder: "holds no files of a known type".
TEST(DescribeSequences, CamerasAndFramesOfARig) {
  const ScratchFolder folder;
  write_names(folder / "rig", {"cam00", "cam01", "cam02"});
  std::filesystem::remove(folder / "rig/cam02/000003.png");
  const std::optional<json> info = describe_sequences(folder / "rig");
  ASSERT_TRUE(info.has_value());
  EXPECT_EQ((*info)["kind"], "capture of image sequences");
  EXPECT_EQ((*info)["cameras"], 3);
  EXPECT_EQ((*info)["camera_names"], json({"cam00", "cam01", "cam02"}));
  EXPECT_EQ((*info)["frames"], 59);
  EXPECT_EQ((*info)["moments"], 20);
  EXPECT_NE((*info)["reading"].dump().find("3 cameras that film together, number N at N / 30 s"),
            std::string::npos);
}

TEST(DescribeSequences, ReportTheRuleForAmbiguousNames) {
  const ScratchFolder folder;
  write_names(folder / "shots", {"left", "right"});
  const std::optional<json> info = describe_sequences(folder / "shots");
  ASSERT_TRUE(info.has_value());
  EXPECT_NE((*info)["reading"].dump().find("--layout photos"), std::string::npos);
}

// `info` reported of either: "holds no files of a known type".
TEST(DescribePhotos, WithAndWithoutPoses) {
  const ScratchFolder folder;
  write_names(folder / "photos", {"images"});
  EXPECT_FALSE(describe_sequences(folder / "photos").has_value());
  const std::optional<json> bare = describe_photos(folder / "photos");
  ASSERT_TRUE(bare.has_value());
  EXPECT_EQ((*bare)["kind"], "capture of photos");
  EXPECT_EQ((*bare)["posed"], false);
  EXPECT_EQ((*bare)["frames"], 20);
  std::filesystem::create_directories(folder / "photos/sparse");
  std::ofstream(folder / "photos/sparse/cameras.txt") << "1 PINHOLE 64 48 50 50 32 24\n";
  std::ofstream(folder / "photos/sparse/images.txt")
      << "1 1 0 0 0 0 0 0 1 000003.png\n\n2 1 0 0 0 0 0 1 1 000004.png\n\n"
         "3 1 0 0 0 0 0 1 1 lost.png\n\n";
  const std::optional<json> posed = describe_photos(folder / "photos");
  ASSERT_TRUE(posed.has_value());
  EXPECT_EQ((*posed)["layout"], "colmap");
  EXPECT_EQ((*posed)["frames"], 2);
  EXPECT_EQ((*posed)["sizes"][0]["width"], 64);
  EXPECT_NE((*posed)["warnings"].dump().find("lost.png"), std::string::npos);
  write_names(folder / "rig", {"cam00", "cam01"});
  EXPECT_FALSE(describe_photos(folder / "rig").has_value());
}

}  // namespace
}  // namespace tessera::testing
