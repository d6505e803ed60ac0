// `tessera ingest` and `tessera run` refuse a folder of captures: with one line that names them,
// also where some are broken, and before anything is written.
#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

/// A folder `all` of two captures with odd names, and of what is none.
class CliSeveralCaptures : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(place("empty"));
    fs::create_directories(place(".hidden"));
    for (const char* name : {"k 'quoted' \"twice\"", "ü Küche 厨房", ".hidden/capture"})
      fs::copy(work_ / "capture", place(name), fs::copy_options::recursive);
    work_.write("all/notes.txt", "a file is no capture");
  }
  fs::path place(const std::string& name) const { return work_ / ("all/" + name); }
  void expect_refused(const std::vector<std::string>& parts) const {
    for (const char* command : {"ingest", "run"}) {
      SCOPED_TRACE(command);
      work_.expect_refused({command, work_.at("all"), "-o", work_.at("out")}, parts);
      EXPECT_FALSE(fs::exists(work_ / "out"));
    }
  }

  CliWorkspace work_;
};

// Seen to fail with detect_layout's own message, which names no capture. Bug put back: `ingest`
// without the check; seen to fail.
TEST_F(CliSeveralCaptures, AreNamedWithTheRemedy) {
  expect_refused({work_.at("all"), "(k 'quoted' \"twice\", ü Küche 厨房)", "name one of them",
                  "`tessera batch`"});
}

TEST_F(CliSeveralCaptures, AreNamedBesideBrokenLinksAndUnreadableFolders) {
  fs::create_directory_symlink("loop", place("loop"));
  fs::create_directory_symlink(work_ / "all", place("self"));
  fs::create_directory_symlink("nowhere", place("dangling"));
  fs::create_directories(place("locked"));
  fs::permissions(place("locked"), fs::perms::none);
  expect_refused({"(k 'quoted' \"twice\",", "ü Küche 厨房)"});
  fs::permissions(place("locked"), fs::perms::owner_all);
}

TEST_F(CliSeveralCaptures, AFolderWithoutAnyIsRefusedAndACaptureWithOneInItIsRead) {
  fs::create_directories(work_ / "none/empty");
  work_.expect_refused({"ingest", work_.at("none"), "-o", work_.at("out")}, {"none", "name the"});
  fs::rename(place("ü Küche 厨房"), work_ / "capture/inner");
  EXPECT_EQ(work_.run_json({"ingest", work_.at("capture"), "-o", work_.at("scene")})["frames"], 4);
}

}  // namespace
}  // namespace tessera::testing
