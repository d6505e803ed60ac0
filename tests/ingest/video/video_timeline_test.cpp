// Timelines from packets alone: times, gaps, duplicates, truncation, container clocks.
#include "ingest/video/video_timeline.h"

#include <gmock/gmock.h>

#include "ingest/video/frame_timing.h"
#include "ingest/video/video_decoder.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using ::testing::HasSubstr;

class Timeline : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
  }
  TemporaryFolder folder_;
};

// A11, B15. Bugs put back, each seen to fail: packets left in order of decoding; a gap measured
// from the mean distance.
TEST_F(Timeline, TimesAreSortedAndGapsNamed) {
  TestVideo video = numbered_video(20);
  for (int i = 0; i < 20; ++i) video.ticks.push_back(512 * (i < 8 ? i : i + 3));
  write_video(folder_ / "cam07.mp4", video);
  const VideoTimeline timeline = read_timeline(folder_ / "cam07.mp4");
  EXPECT_EQ(timeline.ticks, video.ticks);
  EXPECT_EQ(timeline.width, 32);
  EXPECT_EQ(timeline.height, 24);
  EXPECT_DOUBLE_EQ(timeline.frame_seconds, 0.04);
  EXPECT_FALSE(timeline.has_audio);
  EXPECT_FALSE(timeline.clock.has_value());
  ASSERT_EQ(timeline.warnings.size(), 1u);
  for (const char* part : {"cam07.mp4", "camera cam07", "gap after 0.280 s", "0.160 s long",
                           "about 3 frames are missing"})
    EXPECT_THAT(timeline.warnings[0], HasSubstr(part));
}

// Matroska counts milliseconds: two frames closer than that get one time.
TEST_F(Timeline, RepeatedTimesAreNamedAndShownOnce) {
  TestVideo video = numbered_video(10);
  video.b_frames = 0;
  for (int i = 0; i < 10; ++i) video.ticks.push_back(512 * i);
  video.ticks[6] = 512 * 5 + 1;
  write_video(folder_ / "cam1.mkv", video);
  const VideoTimeline timeline = read_timeline(folder_ / "cam1.mkv");
  EXPECT_EQ(timeline.ticks, (std::vector<int64_t>{0, 40, 80, 120, 160, 200, 280, 320, 360}));
  ASSERT_EQ(timeline.warnings.size(), 2u);  // the gap that the moved frame leaves, and this:
  EXPECT_THAT(timeline.warnings[1], HasSubstr("1 frames that repeat"));
  EXPECT_THAT(timeline.warnings[1], HasSubstr("0.200 s"));
  std::vector<int64_t> decoded;
  decode_video(folder_ / "cam1.mkv", [&](VideoFrame frame) {
    decoded.push_back(frame.ticks);
    return true;
  });
  EXPECT_EQ(decoded, timeline.ticks);
}

TEST_F(Timeline, TruncationIsNamedAndWhatIsThereCanBeKept) {
  TestVideo video = numbered_video(20);
  for (size_t i = 0; i < video.frames.size(); ++i)
    video.frames[i] = patterned_image(32, 24, 3, int(i));
  for (const char* name : {"whole.mp4", "whole.mkv"}) {
    write_video(folder_ / name, video);
    const std::string bytes = read_bytes(folder_ / name);
    const std::string cut = std::string("cut") + std::filesystem::path(name).extension().string();
    write_bytes(folder_ / cut, bytes.substr(0, bytes.size() * 7 / 10));
    const VideoTimeline timeline = read_timeline(folder_ / cut);
    ASSERT_FALSE(timeline.warnings.empty()) << name;
    EXPECT_THAT(timeline.warnings[0], HasSubstr(cut + ": camera cut is truncated after "));
    EXPECT_LT(timeline.ticks.size(), 18u);
    EXPECT_GT(timeline.ticks.size(), 9u);

    const auto any = [](VideoFrame) { return true; };
    expect_input_error([&] { decode_video(folder_ / cut, any); }, {cut, "frames could be read"});
    DecodeOptions keep;
    keep.truncation = Truncation::kKeepWhatIsThere;
    std::vector<int64_t> decoded;
    const VideoStream stream = decode_video(
        folder_ / cut,
        [&](VideoFrame frame) {
          decoded.push_back(frame.ticks);
          return true;
        },
        keep);
    EXPECT_EQ(decoded, timeline.ticks) << name;
    ASSERT_EQ(stream.warnings.size(), 1u);
    EXPECT_THAT(stream.warnings[0], HasSubstr("truncated after"));
    size_t count = 0;
    decode_frames(folder_ / cut, timeline.ticks, [&](VideoFrame) { return ++count > 0; });
    EXPECT_EQ(count, timeline.ticks.size());
  }
}

// A frame in the middle whose bytes are wrong is an error with its place, not an image.
TEST_F(Timeline, DamageInTheMiddleNamesCameraAndTime) {
  TestVideo video;
  for (int i = 0; i < 40; ++i) video.frames.push_back(patterned_image(64, 48, 3, i));
  write_video(folder_ / "cam03.mp4", video);
  std::string bytes = read_bytes(folder_ / "cam03.mp4");
  for (size_t i = bytes.size() / 2; i < bytes.size() / 2 + 3000; ++i) bytes[i] = char(i * 31);
  write_bytes(folder_ / "cam03.mp4", bytes);
  const auto any = [](VideoFrame) { return true; };
  expect_input_error([&] { decode_video(folder_ / "cam03.mp4", any); },
                     {"cam03.mp4", "camera cam03", "damaged", " s, "});
}

std::vector<std::string> gaps(const std::vector<int64_t>& ticks) {
  return gap_warnings("cam", ticks, {1, 100});
}

TEST(FrameTiming, ManyGapsBecomeAFewLines) {
  std::vector<int64_t> ticks;
  for (int i = 0; i < 200; ++i) ticks.push_back(4 * i + 10 * (i / 20));  // 9 gaps of 14
  const auto lines = gaps(ticks);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_THAT(lines[0], HasSubstr("0.760 s"));
  EXPECT_THAT(lines[3], HasSubstr("9 gaps in all"));
}

// Bug put back: a line for each gap; seen to fail.
TEST(FrameTiming, AVariableRateIsOneLine) {
  std::vector<int64_t> ticks{0};
  for (int i = 0; i < 100; ++i) ticks.push_back(ticks.back() + (i % 4 == 0 ? 8 : 4));
  const auto lines = gaps(ticks);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], HasSubstr("variable frame rate"));
  EXPECT_THAT(lines[0], HasSubstr("0.0400 to 0.0800 s"));
}

TEST(FrameTiming, AGapIsMoreThanOneAndAHalfMedians) {
  EXPECT_TRUE(gaps({0, 4, 8, 14, 18}).empty());  // 6 = 1.5 · 4
  EXPECT_EQ(gaps({0, 4, 8, 15, 19}).size(), 1u);
  EXPECT_TRUE(gaps({}).empty());
  EXPECT_TRUE(gaps({5}).empty());
  EXPECT_EQ(median_distance({0, 4, 9, 20}), 5);
}

// Known answers: 1 h of drop-frame at 30000/1001 is 107892 frames.
TEST(ContainerClock, Timecodes) {
  const Rational ntsc{30000, 1001}, film{24, 1};
  EXPECT_DOUBLE_EQ(timecode_clock("01:02:03:12", film)->seconds, 3723.5);
  EXPECT_DOUBLE_EQ(timecode_clock("01:00:00;00", ntsc)->seconds, 107892 * 1001 / 30000.0);
  EXPECT_DOUBLE_EQ(timecode_clock("01:00:00:00", ntsc)->seconds, 108000 * 1001 / 30000.0);
  EXPECT_DOUBLE_EQ(timecode_clock("01:02:03:12", film)->day, 86400);
  EXPECT_DOUBLE_EQ(timecode_clock("01:00:00;00", ntsc)->day, 24.0 * 107892 * 1001 / 30000.0);
  EXPECT_DOUBLE_EQ(timecode_clock("01:00:00:00", ntsc)->day, 24.0 * 108000 * 1001 / 30000.0);
  EXPECT_FALSE(timecode_clock("half past four", film).has_value());
  EXPECT_FALSE(timecode_clock("00:00:00:00", {0, 1}).has_value());
}

// Cameras of 50 and 59.94 frames a second that count every second one. Bugs put back, each seen to
// fail: the rate of the frames; the round number that the track states.
TEST(ContainerClock, TimecodesMayCountEverySecondFrame) {
  const auto counted = [](Rational frames, double counts) {
    return timecode_clock("00:00:01:04", timecode_rate(frames, counts))->seconds;
  };
  EXPECT_DOUBLE_EQ(counted({50, 1}, 25), 1 + 4 / 25.0);
  EXPECT_DOUBLE_EQ(counted({60000, 1001}, 30), 34 * 1001 / 30000.0);
  EXPECT_DOUBLE_EQ(counted({120, 1}, 30), 1 + 4 / 30.0);
  EXPECT_DOUBLE_EQ(counted({25, 1}, 25), 1 + 4 / 25.0);
  EXPECT_DOUBLE_EQ(counted({30000, 1001}, 30), 34 * 1001 / 30000.0);
  EXPECT_DOUBLE_EQ(counted({25, 1}, 0), 1 + 4 / 25.0) << "not stated";
  EXPECT_DOUBLE_EQ(counted({60, 1}, 25), 1 + 4 / 60.0) << "another clock";
}

// Bug put back: whole seconds accepted; seen to fail.
TEST(ContainerClock, CreationTimesOfWholeSecondsAreTooCoarse) {
  const double day = creation_seconds("2024-01-28T01:26:33.250000Z").value();
  EXPECT_DOUBLE_EQ(day, 1706405193.25);
  EXPECT_FALSE(creation_seconds("2024-01-28T01:26:33.000000Z"));
  EXPECT_FALSE(creation_seconds("2024-01-28T01:26:33Z"));
  EXPECT_FALSE(creation_seconds("some day at 1.5"));
}

// The timecode is that of the first frame shown. Bug put back: taken for tick 0; seen to fail.
TEST_F(Timeline, ClockIsTheTimeOfTickZero) {
  TestVideo video = numbered_video(5);
  for (int i = 0; i < 5; ++i) video.ticks.push_back(512 * (i + 50));
  video.tags["timecode"] = "00:00:10:05";
  write_video(folder_ / "a.mkv", video);
  const VideoTimeline timeline = read_timeline(folder_ / "a.mkv");
  ASSERT_TRUE(timeline.clock.has_value());
  EXPECT_NEAR(timeline.clock->seconds + timeline.seconds(0), 10.2, 1e-9);
  EXPECT_NEAR(timeline.seconds(0), 2, 1e-9);
}

}  // namespace
}  // namespace tessera
