// The timesteps of an export: closed forms of each option, and invalid options.
#include "tools/camera_paths/export_times.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {
namespace {

const TimeAxis kFourSeconds{100, 4};  // a clip of four seconds whose clock starts at 100

std::vector<double> times_of(ExportTimes request) {
  return export_times(request, kFourSeconds, true);
}

// Bug put back: count in place of count − 1 in the step; seen to fail.
TEST(ExportTimes, FramesReachFromTheFirstTimestepToTheLast) {
  EXPECT_EQ(times_of({.frames = 5}), (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(times_of({.frames = 1}), (std::vector<double>{0}));
  EXPECT_EQ(times_of({.frames = 3, .range = "0.25:0.75"}), (std::vector<double>{0.25, 0.5, 0.75}));
  EXPECT_EQ(times_of({.frames = 1, .range = "0.25:"}), (std::vector<double>{0.25}));
}

// Bug put back: the rate over the range's share of normalised time, not over its seconds; seen to
// fail.
TEST(ExportTimes, RatesAreByTheCapturesClock) {
  const std::vector<double> whole = times_of({.fps = 2});
  ASSERT_EQ(whole.size(), 9u) << "both ends";
  EXPECT_EQ(whole[1], 0.125);
  EXPECT_EQ(whole.back(), 1);
  EXPECT_EQ(times_of({.fps = 2, .range = "1s:2s"}), (std::vector<double>{0.25, 0.375, 0.5}));
  EXPECT_EQ(times_of({.fps = 2, .range = "1s:2.4s"}).size(), 3u) << "none past the end";
  EXPECT_EQ(times_of({.fps = 29.97}).size(), 120u);
}

TEST(ExportTimes, WithoutOptionsAreTwentyFourASecond) {
  EXPECT_EQ(times_of({}).size(), 97u);
  EXPECT_EQ(times_of({.range = "1s:2s"}).size(), 25u);
  EXPECT_EQ(export_times({}, {0, 1000}, true).size(), 300u);
  EXPECT_EQ(export_times({}, {0, 0.001}, true).size(), 2u);
  EXPECT_EQ(export_times({}, kFourSeconds, false), (std::vector<double>{0}));
  EXPECT_EQ(times_of({.time = 0.3}), (std::vector<double>{0.3}));
}

/// `count` frames at `fps` frames in a unit of time from `begin` on.
std::set<double> filmed(int count, double fps, double begin = 0) {
  std::set<double> timesteps;
  for (int i = 0; i < count; ++i) timesteps.insert(begin + i / fps);
  return timesteps;
}

// Thirty frames of thirty cameras, the clocks of three of which were set by 3 to 5 ms: there are
// more than thirty distinct times and still thirty frames. Bugs put back: distinct times counted;
// a camera's mean distance of frames for its rhythm; the median distance alone, on times that are
// rounded to milliseconds; each seen to fail.
TEST(CaptureTimes, GoByTheRateOfTheCameras) {
  CameraTimesteps cameras;
  for (int c = 0; c < 30; ++c)
    cameras["cam" + std::to_string(c)] = filmed(30, 29, c % 10 == 0 ? 0.002 + 0.0001 * c : 0);
  EXPECT_NEAR(capture_rate(cameras), 29, 1e-9);
  const std::vector<double> times = capture_times(cameras, 60);
  ASSERT_EQ(times.size(), 30u);
  EXPECT_EQ(times.front(), 0);
  EXPECT_EQ(times.back(), *cameras["cam20"].rbegin());
  EXPECT_EQ(capture_times(cameras, 8).size(), 8u);

  std::set<double> with_gap = filmed(300, 30), rounded;
  for (int i = 100; i < 150; ++i) with_gap.erase(i / 30.0);
  EXPECT_NEAR(capture_rate({{"gap", with_gap}}), 30, 1e-9);
  for (int i = 0; i < 300; ++i) rounded.insert(std::round(1000 * i / 30.0) / 1000);
  EXPECT_NEAR(capture_rate({{"rounded", rounded}}), 30, 0.01);
}

TEST(CaptureTimes, OfPhotosAndOfOneTimestep) {
  EXPECT_EQ(capture_times({{"a", {0}}, {"b", {0}}}, 60), (std::vector<double>{0}));
  EXPECT_EQ(capture_rate({{"a", {0.5}}}), 0);
  EXPECT_TRUE(capture_times({}, 60).empty());
  EXPECT_EQ(capture_times({{"a", {0}}, {"b", {0.5}}, {"c", {1}}}, 60),
            (std::vector<double>{0, 0.5, 1}));
}

// Bug put back: 24 a second although the cameras' rate is known; seen to fail.
TEST(ExportTimes, AtTheRateOfTheCaptureWhereItIsKnown) {
  EXPECT_EQ(times_of({.capture_fps = 7.5}).size(), 31u);
  EXPECT_EQ(times_of({.frames = 5, .capture_fps = 7.5}).size(), 5u);
  EXPECT_EQ(times_of({.fps = 2, .capture_fps = 7.5}).size(), 9u);
}

// Bug put back: seconds counted from the clock's zero, not from the clip's first timestep; seen to
// fail.
TEST(ExportTimes, RangesHaveEitherUnitAndEitherEnd) {
  const auto expect = [](const char* text, double begin, double end) {
    const TimeRange range = parse_time_range(text, kFourSeconds);
    EXPECT_DOUBLE_EQ(range.begin, begin) << text;
    EXPECT_DOUBLE_EQ(range.end, end) << text;
  };
  expect("0:1", 0, 1);
  expect(".25:", 0.25, 1);
  expect(":1s", 0, 0.25);
  expect("1s:0.5", 0.25, 0.5);
  expect("0s:4s", 0, 1);
  expect(":", 0, 1);
}

TEST(ExportTimes, RefuseWhatMakesNoFrames) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // Bug put back: ends read by strtod, in the locale's way and with all that C reads; seen to fail.
  for (const char* text : {"0.5", "a:b", "0x0:1", " 0:1", "0:1x", "1:0", "0.5:0.5", "-1:1", "0:2",
                           "0s:5s", "s:1s", "nan:1", "0:inf", "0:1:2"})
    expect_input_error([&] { times_of({.range = text}); }, {"--range", text, "expected A:B"});
  expect_input_error([&] { times_of({.frames = 0}); }, {"--frames", "0"});
  expect_input_error([&] { times_of({.frames = 100001}); }, {"--frames", "100001"});
  for (const double fps : {0.0, -1.0, 1e9, nan})
    expect_input_error([&] { times_of({.fps = fps}); }, {"--fps", "--frames"});
  expect_input_error([&] { times_of({.time = nan}); }, {"--time"});
  expect_input_error([&] { times_of({.time = 5}); }, {"--time is 5, expected 0 (first) to 1"});
  expect_input_error([&] { times_of({.time = -0.1}); }, {"--time is -0.1"});
}

}  // namespace
}  // namespace tessera::testing
