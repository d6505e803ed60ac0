// Cameras, frames and reading of image sequences, as `tessera info` describes them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/scratch_folder.h"
#include "tools/commands/describe.h"

namespace tessera {
namespace {

using nlohmann::json;
using testing::ScratchFolder;

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

TEST(DescribeSequences, NothingOfPhotos) {
  const ScratchFolder folder;
  write_names(folder / "photos", {"images"});
  EXPECT_FALSE(describe_sequences(folder / "photos").has_value());
}

}  // namespace
}  // namespace tessera
