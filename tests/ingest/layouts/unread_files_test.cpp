// Files of a capture that its user may think are used.
#include "ingest/layouts/unread_files.h"

#include <gtest/gtest.h>

#include "ingest/images/listing.h"
#include "ingest/ingest.h"
#include "ingest/layouts/video_files.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;

const std::string kHeic(
    "\0\0\0\x18"
    "ftypheic",
    12);

void put(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::create_directories(file.parent_path());
  write_bytes(file, bytes);
}

// Bugs put back, each seen to fail: extensions compared with their case; hidden files counted; only
// the folder itself looked at; a list of extensions.
TEST(UnreadFiles, AreCountedByExtension) {
  const TemporaryFolder folder;
  for (const char* name : {"images/a.HEIC", "images/b.heic", "images/c.png", "images/._d.heic",
                           ".hidden/e.heic", "cam00/raw/f.dng", "notes.txt", "a/@eaDir/g.dng"})
    put(folder / name, name[7] == 'a' || name[7] == 'b' ? kHeic : std::string("II*\0", 4));
  const std::vector<std::string> lines = unread_files(folder.path(), {}, {}, false).warnings;
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("1 .dng file is not read"), std::string::npos) << lines[0];
  EXPECT_NE(lines[1].find("2 .heic files are not read"), std::string::npos) << lines[1];
  EXPECT_TRUE(unread_files(folder / "nowhere", {}, {}, false).warnings.empty());
}

// Bug put back: extensions decide; seen to fail.
TEST(UnreadFiles, ContentsDecideWhereNamesSayNothing) {
  const TemporaryFolder folder;
  std::string packets(3 * 188, '\0');
  for (size_t i = 0; i < packets.size(); i += 188) packets[i] = 'G';
  const std::pair<const char*, std::string> videos[] = {{"a.xyz", std::string("\0\0\0\x18"
                                                                              "ftyp3gp4",
                                                                              12)},
                                                        {"b", "\x1a\x45\xdf\xa3"},
                                                        {"c.tod", packets},
                                                        {"d.q7", "FLV\1"},
                                                        {"e.film", "RIFF1234AVI "},
                                                        {"f", "\x30\x26\xb2\x75\x8e\x66\xcf\x11"}};
  for (const auto& [name, bytes] : videos) {
    put(folder / name, bytes);
    EXPECT_EQ(kind_of_file(folder / name), FileKind::kVideo) << name;
  }
  EXPECT_EQ(video_cameras_in(folder.path()).size(), 6u);
  put(folder / "g.nef", "MM");
  put(folder / "h.notes", "words");
  EXPECT_EQ(kind_of_file(folder / "g.nef"), FileKind::kOther) << "cut off";
  EXPECT_EQ(kind_of_file(folder / "h.notes"), FileKind::kOther);
}

// What a rig may have lost. Bugs put back, each seen to fail: videos one level below alone are
// looked for; those that are read are named; folders in images/ are not looked at.
TEST(UnreadFiles, VideosAndCamerasThatAreNoneOfTheRigAreNamed) {
  const TemporaryFolder folder;
  for (const char* name :
       {"cam00.mp4", "cam01.mp4", "cam02/DCIM/v.mp4", "cam03/0001.png", "images/cam04/0001.png",
        "depth/0001.png", "masks/0001.png", "cam05/notes.txt", ".trash/cam06.mp4"})
    put(folder / name, "");
  Capture capture;
  for (const char* name : {"cam00.mp4", "cam01.mp4"})
    capture.clips.push_back({name, folder / name, {}, {}});
  const UnreadFiles unread = unread_files(folder.path(), taken_files(capture), {}, true);
  ASSERT_EQ(unread.warnings.size(), 2u);
  EXPECT_NE(unread.warnings[0].find("they are videos: cam02/DCIM/v.mp4;"), std::string::npos);
  EXPECT_NE(unread.warnings[1].find("hold images: cam03 (1 image), images/cam04 (1 image);"),
            std::string::npos);
  EXPECT_EQ(unread.notes, (std::vector{folder.path().string() + ": not read: depth (1 image)"}));
  EXPECT_TRUE(
      unread_files(folder.path(), taken_files(capture), folder / "depth", true).notes.empty());
}

TEST(UnreadFiles, MasksBesideTheImagesAreNamed) {
  const TemporaryFolder folder;
  put(folder / "masks/readme.txt", "");
  EXPECT_EQ(unused_masks(folder.path()), "");
  put(folder / "masks/a.png", "");
  EXPECT_NE(unused_masks(folder.path()).find("pass --masks " + (folder / "masks").string()),
            std::string::npos);
}

// Bugs put back, each seen to fail: named after success alone; the kind of the error lost.
TEST(UnreadFiles, AreNamedWhereACaptureIsRefused) {
  const TemporaryFolder folder;
  put(folder / "phone/IMG_0001.HEIC", kHeic);
  put(folder / "phone/IMG_0002.HEIC", kHeic);
  const auto ingest = [&] { ingest_capture(folder / "phone", folder / "scene", {}, {}); };
  expect_input_error(ingest, {"no images", "2 .heic files are not read; to use them, convert"});
  for (const char* name :
       {"phone/a/0001.png", "phone/a/0002.png", "phone/b/0001.png", "phone/b/0002.png"}) {
    put(folder / name, "");
  }
  EXPECT_THROW(ingest(), AmbiguousCapture);
  IngestOptions photos;
  photos.scale = 2;
  expect_input_error([&] { ingest_capture(folder / "phone", folder / "scene", photos, {}); },
                     {"--scale is 2"});
}

}  // namespace
}  // namespace tessera
