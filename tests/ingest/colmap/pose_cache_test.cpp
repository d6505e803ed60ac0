// Results of COLMAP under their keys: what is kept, what is found again, and how many.
#include "ingest/colmap/pose_cache.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {
namespace {

using std::filesystem::exists;

/// A workspace after COLMAP, with empty models.
ColmapWorkspace finished(const std::filesystem::path& folder) {
  const ColmapWorkspace work(folder);
  for (const char* name : {"sparse/0", "refined/chosen", "refined/as mapped", "points/model"})
    std::filesystem::create_directories(work.folder / name);
  write_bytes(work.folder / "sparse/0/cameras.bin", "mapped");
  write_bytes(work.folder / "refined/chosen/cameras.txt", "chosen");
  write_bytes(work.folder / "points/key.txt", "key and split");
  write_bytes(work.database, "features");
  work.store_key("key");
  return work;
}

// Bugs put back, each seen to fail: the key of the points left out; the database kept, too.
TEST(PoseCache, GivesModelsBackUnderTheirKeyAlone) {
  const TemporaryFolder folder;
  const PoseCache cache(folder / "cache");
  cache.keep("a", finished(folder / "one"));
  const ColmapWorkspace other(folder / "two");
  EXPECT_FALSE(cache.fetch("b", other));
  EXPECT_FALSE(other.holds("key"));
  ASSERT_TRUE(cache.fetch("a", other));
  EXPECT_TRUE(other.holds("key"));
  EXPECT_EQ(read_bytes(other.folder / "sparse/0/cameras.bin"), "mapped");
  EXPECT_EQ(read_bytes(other.folder / "refined/chosen/cameras.txt"), "chosen");
  EXPECT_TRUE(ColmapWorkspace(other.folder / "points").holds("key and split"));
  EXPECT_FALSE(exists(folder / "cache/a/database.db"));
  EXPECT_FALSE(exists(folder / "cache/a/refined/as mapped"));
}

// Bug put back: nothing removed; seen to fail.
TEST(PoseCache, KeepsTheLastOnesUsed) {
  const TemporaryFolder folder;
  const PoseCache cache(folder / "cache");
  const ColmapWorkspace work = finished(folder / "work");
  const auto now = std::filesystem::file_time_type::clock::now();
  for (size_t i = 0; i < PoseCache::kMost; ++i) {
    cache.keep(std::to_string(i), work);
    std::filesystem::last_write_time(folder / ("cache/" + std::to_string(i)),
                                     now - std::chrono::hours(100 - i));
  }
  EXPECT_TRUE(cache.fetch("0", ColmapWorkspace(folder / "used")));
  cache.keep("new", work);
  EXPECT_TRUE(exists(folder / "cache/0"));
  EXPECT_FALSE(exists(folder / "cache/1"));
  EXPECT_TRUE(exists(folder / "cache/2"));
  EXPECT_TRUE(exists(folder / "cache/new"));
}

TEST(PoseCache, NoFolderOrNoAccessIsNoFailure) {
  const TemporaryFolder folder;
  const ColmapWorkspace work = finished(folder / "work");
  PoseCache("").keep("a", work);
  EXPECT_FALSE(PoseCache("").fetch("a", work));
  write_bytes(folder / "file", "");
  const PoseCache blocked(folder / "file");
  EXPECT_NO_THROW(blocked.keep("a", work));
}

}  // namespace
}  // namespace tessera::testing
