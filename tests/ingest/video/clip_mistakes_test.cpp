// A copied recording, images numbered from another number and a frozen input are named, and nothing
// else is.
#include "ingest/video/clip_mistakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "ingest/files/png.h"
#include "ingest/ingest.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera::testing {
namespace {

// Bugs put back, each seen to fail: files of equal size taken for copies; images that begin alike,
// too.
TEST(ClipMistakes, OneRecordingUnderSeveralNames) {
  const TemporaryFolder folder;
  std::vector<RigClip> clips;
  const std::string contents[] = {"abcd", "abce", "abcd", "abc"};
  for (size_t i = 0; i < 4; ++i) {
    const auto file = folder / fmt::format("cam{}.mp4", i);
    write_bytes(file, contents[i]);
    clips.push_back({fmt::format("cam{}", i), file, {}, {}});
  }
  auto lines = copied_clips(clips);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].starts_with("cam0, cam2 are one recording, byte for byte")) << lines[0];
  write_bytes(folder / "more.mp4", "efg");
  clips[2].chapters = {folder / "more.mp4"};
  EXPECT_TRUE(copied_clips(clips).empty());
  clips.resize(2);
  for (RigClip& clip : clips) clip.images = {{0, folder / "cam0.mp4"}, {1, clip.video}};
  EXPECT_TRUE(copied_clips(clips).empty());
}

RigClip numbered(const std::string& name, int64_t first, std::vector<int64_t> more) {
  RigClip clip{name, "folder", {}, {}};
  for (const int64_t number : more) {
    clip.timeline.ticks.push_back(first + number);
    clip.images.push_back({first + number, "image"});
  }
  return clip;
}

// Bug put back: cameras with other gaps compared; seen to fail.
TEST(ClipMistakes, ImagesNumberedFromAnotherNumber) {
  std::vector<RigClip> clips{numbered("a", 0, {0, 1, 2, 3}), numbered("b", 1, {0, 1, 2, 3}),
                             numbered("c", 0, {0, 1, 2, 3})};
  EXPECT_TRUE(shifted_numbers(clips).starts_with(
      "the images of b are numbered from 1, as many of a, c from 0: they count as taken 1 number "
      "later"))
      << shifted_numbers(clips);
  clips[1] = numbered("b", 1, {0, 1, 2});  // its first image is missing
  EXPECT_EQ(shifted_numbers(clips), "");
  clips[1] = numbered("b", 1, {0, 1, 2, 4});
  EXPECT_EQ(shifted_numbers(clips), "");
  clips[1] = numbered("b", 0, {0, 1, 2, 3});
  EXPECT_EQ(shifted_numbers(clips), "");
}

// Bugs put back, each seen to fail: the first stretch kept, not the longest; the median not asked.
TEST(ClipMistakes, AFrozenInput) {
  const Image8 a{1, 1, 3, {1, 2, 3}}, b{1, 1, 3, {1, 2, 4}};
  std::vector<FrozenStretch> cameras;
  for (int c = 0; c < 3; ++c) {
    FrozenFrames frames(fmt::format("cam{}", c));
    for (int i = 0; i < 20; ++i)
      frames.see(c == 1 && i >= 8 && i < 16 ? a : i % 4 < 2 ? a : b, 0.1 * i);
    cameras.push_back(frames.longest());
  }
  EXPECT_EQ(cameras[0].frames, 2);
  const auto lines = frozen_warnings(cameras);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("camera cam1 repeats one image from 0.800 s to 1.700 s (10 frames)"),
            std::string::npos)
      << lines[0];
  cameras[0] = cameras[2] = cameras[1];  // a still scene
  EXPECT_TRUE(frozen_warnings(cameras).empty());
}

// Of the capture as a whole. Bugs put back, each seen to fail: one of the three not called.
TEST(ClipMistakes, AreWarnedOfWhenACaptureIsPrepared) {
  const TemporaryFolder folder;
  std::string cameras;
  for (int c = 0; c < 5; ++c) {
    const std::string name = fmt::format("cam{:02}", c);
    std::filesystem::create_directories(folder / "capture" / name);
    for (int n = 0; n < 8; ++n) {
      const int shown = c == 3 ? std::min(n, 2) : n;
      const auto grey = uint8_t(10 * shown + 20 * (c == 2 ? 1 : c));
      write_png(folder / "capture" / name / fmt::format("{:04}.png", n + (c == 4 ? 1 : 0)),
                constant_image(32, 24, {grey, grey, grey}));
    }
    cameras += fmt::format(
        R"({}{{"name": "{}", "K": [[50, 0, 16], [0, 50, 12], [0, 0, 1]], "w": 32, "h": 24,)"
        R"( "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "T": [{}, 0, 4]}})",
        c == 0 ? "" : ", ", name, 0.3 * c);
  }
  write_bytes(folder / "cameras.json", "[" + cameras + "]");
  IngestOptions options;
  options.poses.source = {PoseSource::kCameras, folder / "cameras.json"};
  options.sync.method = SyncMethod::kNone;
  options.cloud = CloudDensity::kNone;
  const IngestReport report = ingest_capture(folder / "capture", folder / "scene", options,
                                             [](std::string_view, int64_t, int64_t) {});
  const auto warned = [&](const std::string& text) {
    return std::any_of(report.warnings.begin(), report.warnings.end(),
                       [&](const auto& line) { return line.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(warned("cam01, cam02 are one recording"))
      << fmt::format("{}", report.warnings.size());
  EXPECT_TRUE(warned("the images of cam04 are numbered from 1"));
  EXPECT_TRUE(warned("camera cam03 repeats one image from 0.067 s to 0.233 s (6 frames)"));
}

}  // namespace
}  // namespace tessera::testing
