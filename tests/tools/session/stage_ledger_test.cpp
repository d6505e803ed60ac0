// The stamps of a capture's files, by which a stage detects that its input has changed.
#include "tools/cli/stage_ledger.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

// A camera's folder may be a link, which the reader of images follows. Bugs put back, each seen to
// fail: links to folders passed over; a link to the folder that holds it followed for ever.
TEST(StageLedger, StampsFollowLinkedFolders) {
  const ScratchFolder folder;
  fs::create_directories(folder / "data/x");
  fs::create_directories(folder / "capture");
  write_text_file(folder / "data/x/000.png", "one");
  write_text_file(folder / "capture/000.png", "another");
  fs::create_directory_symlink(folder / "data/x", folder / "capture/cam00");
  fs::create_directory_symlink(folder / "capture", folder / "capture/again");
  fs::create_symlink(folder / "gone", folder / "capture/broken");
  const nlohmann::json before = file_stamps(folder / "capture");
  EXPECT_EQ(before.size(), 2u) << before.dump(1);
  write_text_file(folder / "data/x/000.png", "three letters more");
  EXPECT_NE(file_stamps(folder / "capture"), before);
  EXPECT_EQ(file_stamps(folder / "capture/000.png").size(), 1u);
  EXPECT_EQ(file_stamps(folder / "nowhere").size(), 0u);
}

// Bugs put back, each seen to fail: both ends alone; text sampled; a video of many bytes read
// whole.
TEST(StageLedger, StampsSeeAChangedByteInTheMiddle) {
  const ScratchFolder folder;
  const struct {
    const char* name;
    std::string contents;
    size_t place;
    bool seen;
  } files[] = {{"transforms.json", std::string(300000, '7'), 150001, true},
               {"calibration.yml", std::string(70000, '7'), 33333, true},
               {"poses_bounds.npy", std::string(30000, '\0'), 15001, true},
               {"sparse/0/cameras.bin", std::string(9000, '\0'), 4500, true},
               {"cam00.mp4", std::string(900000, '\0'), 450001, false},
               {"cam01.mp4", std::string(900000, '\0'), 99600, true}};
  for (const auto& [name, contents, place, seen] : files) {
    const fs::path file = folder / name;
    fs::create_directories(file.parent_path());
    write_text_file(file, contents);
    const nlohmann::json before = file_stamps(file);
    std::string changed = contents;
    changed[place] = '8';
    write_text_file(file, changed);
    EXPECT_EQ(file_stamps(file) != before, seen) << name;
    changed.back() = '8';
    write_text_file(file, changed);
    EXPECT_NE(file_stamps(file), before) << name;
  }
}

}  // namespace
}  // namespace tessera::testing
