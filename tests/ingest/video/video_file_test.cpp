// Files that are no videos give one clear line each; the real clips are decoded completely and at
// their times.
#include <unistd.h>

#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;

/// Each reader refuses the file in one line that names it.
void expect_refused(const std::filesystem::path& path, const std::vector<std::string>& parts) {
  std::vector<std::string> named = parts;
  named.push_back(path.filename().string());
  expect_input_error([&] { probe_video(path); }, named);
  expect_input_error([&] { read_timeline(path); }, named);
  expect_input_error([&] { decode_video(path, [](VideoFrame) { return true; }); }, named);
  expect_input_error([&] { decode_frames(path, {0}, [](VideoFrame) { return true; }); }, named);
}

// Bug put back: the path ignored before libavformat; seen to fail (the folder, the loop).
TEST(BadVideo, OneLineNamesFileAndRemedy) {
  const TemporaryFolder folder;
  write_bytes(folder / "empty.mp4", "");
  write_bytes(folder / "text.mp4", "no video at all, only words and more words");
  write_bytes(folder / "noise.mp4", std::string(5000, '\x9c'));
  write_bytes(folder / "playlist.mp4", "#EXTM3U\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n");
  std::filesystem::create_directory(folder / "cam.mp4");
  std::filesystem::create_symlink(folder / "loop_b.mp4", folder / "loop_a.mp4");
  std::filesystem::create_symlink(folder / "loop_a.mp4", folder / "loop_b.mp4");
  expect_refused(folder / "empty.mp4", {"cannot be opened", "it is empty", "copy it again"});
  expect_refused(folder / "text.mp4", {"cannot be opened", "copy or encode"});
  expect_refused(folder / "noise.mp4", {"encode"});
  expect_refused(folder / "playlist.mp4", {"encode"});
  expect_refused(folder / "missing.mp4", {"cannot be opened", "check the path"});
  expect_refused(folder / "cam.mp4", {"cannot be opened", "is a folder", "move or rename"});
  expect_refused(folder / "loop_a.mp4", {"cannot be opened", "in a circle", "put the video"});
}

TEST(BadVideo, UnreadableFile) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read every file";
  const TemporaryFolder folder;
  write_bytes(folder / "secret.mp4", "words");
  std::filesystem::permissions(folder / "secret.mp4", std::filesystem::perms::none);
  expect_refused(folder / "secret.mp4", {"not permitted", "chmod +r"});
}

/// As `ffprobe -select_streams v:0 -show_entries frame=pts` lists them (FFmpeg 5.1).
struct RealClip {
  const char* name;
  int width, height;
  size_t frames;
  int64_t first, last, ticks_per_second;
};
constexpr RealClip kOddClips[] = {
    {"av1_video.mkv", 640, 360, 125, 0, 4960, 1000},
    {"bt709_full_range.mp4", 1280, 720, 30, 0, 14848, 15360},
    {"h264_10bits.mp4", 200, 200, 30, 0, 14848, 15360},
    {"h265_10bits.mp4", 200, 200, 30, 0, 14848, 15360},
    {"h265_video.mp4", 128, 128, 10, 0, 9216, 10240},
    {"nasa_13013.mp4", 480, 270, 390, 0, 389389, 30000},  // the larger of two tracks, v:1
    {"testsrc2.mp4", 1280, 720, 60, 0, 30208, 15360},
    {"var_fps_video.mp4", 128, 128, 300, 0, 229376, 15360},
};
constexpr RealClip kRigClips[] = {
    {"cam01.mp4", 1080, 1920, 100, 0, 25344, 15360},
    {"cam02.mp4", 1080, 1920, 100, 0, 25344, 15360},
    {"cam03.mp4", 1088, 1920, 100, 0, 25344, 15360},
    {"cam04.mp4", 1088, 1920, 100, 0, 25344, 15360},
};

void expect_whole(const std::filesystem::path& folder, const RealClip& clip) {
  const VideoTimeline timeline = read_timeline(folder / clip.name);
  EXPECT_EQ(timeline.time_base.denominator, clip.ticks_per_second) << clip.name;
  EXPECT_EQ(timeline.width, clip.width) << clip.name;
  EXPECT_EQ(timeline.height, clip.height) << clip.name;
  ASSERT_EQ(timeline.ticks.size(), clip.frames) << clip.name;
  EXPECT_EQ(timeline.ticks.front(), clip.first) << clip.name;
  EXPECT_EQ(timeline.ticks.back(), clip.last) << clip.name;
  DecodeOptions small;  // only times are checked
  small.width = clip.width / 8;
  small.height = clip.height / 8;
  std::vector<int64_t> decoded;
  decode_video(
      folder / clip.name,
      [&](VideoFrame frame) {
        EXPECT_EQ(frame.image.width, small.width);
        decoded.push_back(frame.ticks);
        return true;
      },
      small);
  EXPECT_EQ(decoded, timeline.ticks) << clip.name;
}

TEST(RealVideo, OddClipsDecodeWholeAtTheirTimes) {
  TESSERA_NEED_DATA(folder, "video_odd");
  for (const RealClip& clip : kOddClips) expect_whole(folder, clip);
}

TEST(RealVideo, RigClipsDecodeWholeAtTheirTimes) {
  TESSERA_NEED_DATA(folder, "video_4cam");
  for (const RealClip& clip : kRigClips) expect_whole(folder, clip);
}

TEST(RealVideo, AVariableRateIsSaidInOneLine) {
  TESSERA_NEED_DATA(folder, "video_odd");
  EXPECT_LE(read_timeline(folder / "var_fps_video.mp4").warnings.size(), 1u);
  EXPECT_TRUE(read_timeline(folder / "nasa_13013.mp4").has_audio);
}

}  // namespace
}  // namespace tessera
