// The time that cameras film together, against intervals found by hand.
#include "ingest/clocks/shared_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tessera {
namespace {

using Times = std::vector<std::vector<double>>;

std::vector<double> times_of_camera(int count, double fps, double offset = 0) {
  std::vector<double> seconds;
  for (int i = 0; i < count; ++i) seconds.push_back(offset + i / fps);
  return seconds;
}

void expect_interval(const TimeInterval& interval, double first, double last) {
  EXPECT_DOUBLE_EQ(interval.first, first);
  EXPECT_DOUBLE_EQ(interval.last, last);
}

TEST(SharedTime, IsOfAllFromLatestFirstToEarliestLast) {
  const Times clips{times_of_camera(10, 10), times_of_camera(10, 10, 0.25), {0.1, 5}};
  expect_interval(longest_interval(clips, 0), 0.25, 0.9);
  EXPECT_TRUE(longest_interval({clips[0], times_of_camera(10, 10, 3)}, 0).empty());
}

// Bug put back: the ends alone counted, so that another camera may be missing at each time; seen to
// fail.
TEST(SharedTime, IsTheLongestInWhichEnoughCamerasFilm) {
  expect_interval(longest_interval({{0, 4}, {1, 9}, {2, 9}, {0, 9}}, 1), 1, 9);
  expect_interval(longest_interval({{0, 4}, {5, 9}, {0, 9}, {0, 9}}, 1), 0, 4);
  std::mt19937 random(5);
  std::uniform_int_distribution<int> time(0, 20);
  for (int i = 0; i < 300; ++i) {
    Times clips;
    for (int c = 0; c < 6; ++c) {
      const int a = time(random), b = time(random);
      clips.push_back({double(std::min(a, b)), double(std::max(a, b))});
    }
    const auto films = [&](double t) {
      return std::count_if(clips.begin(), clips.end(), [&](const std::vector<double>& clip) {
               return clip.front() <= t && t <= clip.back();
             }) >= 4;
    };
    int longest = -1;
    for (int first = 0, length = -1; first <= 20; ++first, length = -1)
      for (double t = first; films(t) && t <= 20; t += 0.5)
        if (t == int(t)) longest = std::max(longest, ++length);
    const TimeInterval found = longest_interval(clips, 2);
    EXPECT_EQ(found.last - found.first, longest);
  }
}

// Bugs put back, each seen to fail: any gain counts; the window is not looked at.
TEST(SharedTime, AFewCamerasDoNotShortenIt) {
  const std::vector<double> whole = times_of_camera(16, 24);
  for (const auto& odd : {times_of_camera(12, 24), times_of_camera(12, 24, 4 / 24.0),
                          times_of_camera(16, 24, -4 / 24.0), times_of_camera(16, 24, 9),
                          std::vector<double>{0.25}}) {
    const SharedTime shared = shared_time({whole, whole, odd, whole}, {});
    expect_interval(shared.interval, 0, 15 / 24.0);
    EXPECT_EQ(shared.films_all_of, (std::vector<char>{1, 1, 0, 1}));
  }
  const Times clips{whole, times_of_camera(6, 24), whole};
  const std::vector<char> all{1, 1, 1};
  FrameWindow window;
  window.frames = 6;
  EXPECT_EQ(shared_time(clips, window).films_all_of, all);
  window = {0, 0.25, {}, {}};
  EXPECT_EQ(shared_time(clips, window).films_all_of, all);
  window = {0.25, {}, {}, {}};
  EXPECT_NE(shared_time(clips, window).films_all_of, all);
  EXPECT_EQ(shared_time({whole, whole, times_of_camera(15, 24)}, {}).films_all_of, all);
}

// Bug put back: one camera at most; seen to fail (nothing is won without one of the two).
TEST(SharedTime, AQuarterOfTheCamerasMayBeMissing) {
  const std::vector<double> whole = times_of_camera(16, 24), part = times_of_camera(10, 24);
  expect_interval(shared_time({whole, whole, part, whole, whole, part, whole, whole}, {}).interval,
                  0, 15 / 24.0);
  expect_interval(shared_time({whole, whole, part, whole, whole, part, whole}, {}).interval, 0,
                  9 / 24.0);
  expect_interval(shared_time({whole, part}, {}).interval, 0, 9 / 24.0);
}

}  // namespace
}  // namespace tessera
