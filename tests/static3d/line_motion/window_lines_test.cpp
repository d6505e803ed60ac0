// Windows of a clip as one set of lines: near what the windows show, at their borders too, in the
// light of each.
#include <gtest/gtest.h>

#include <cmath>

#include "static3d/line_motion/line_model.h"
#include "tests/recon4d/model/carried_model.h"
#include "tests/static3d/line_motion/some_clip.h"
#include "tests/static3d/tessera4d/window_model.h"

namespace tessera::testing {
namespace {

const std::vector<FileWindow> kTwoCores{{{0, 0.6}, {0, 0.47}}, {{0.4, 1}, {0.47, 1}}};

/// As a run has it: what stands still is in the light of the window.
GaussianModel in_window(const GaussianModel& model, const FileWindow& window) {
  GaussianModel part = in_time_of(window, model);
  apply_light(window.light, part.static_set);
  return part;
}

/// A clip whose Gaussians move slowly, some of them through all of it.
GaussianModel slow_clip() {
  GaussianModel model = some_clip(1, 8, 30);
  const GaussianSpans<float> values = model.dynamic_set.values();
  for (int64_t n = 0; n < values.count; ++n) {
    if (n % 3 == 0) *values.at(kLogScaleTime, n) = float(std::log(3));
    for (int k = 0; k < 3; ++k) values.at(kVelocity, n)[k] *= 0.2f;
  }
  return model;
}

GaussianModel lines_of_two(const GaussianModel& model, const std::vector<FileWindow>& windows) {
  return line_model({windows, [&](int i) { return in_window(model, windows[size_t(i)]); }}, model);
}

// Bug put back: what is seen beyond a core drawn by both windows; seen to fail.
TEST(WindowLines, AreNearWhatTheWindowsShow) {
  const GaussianModel model = slow_clip();
  const GaussianModel lines = lines_of_two(model, kTwoCores);
  EXPECT_EQ(lines.static_set.count(), 8);
  EXPECT_GT(likeness(lines, model, {0, 0.2, 0.35, 0.6, 0.8, 1}), 46);
  EXPECT_GT(likeness(lines, model, {0.42, 0.47, 0.52}), 46) << "near the border";
}

TEST(WindowLines, OfOneWindowAreItsOwn) {
  const GaussianModel model = slow_clip();
  const GaussianModel lines = lines_of_two(model, {FileWindow{}});
  EXPECT_EQ(lines.dynamic_set.count(), 30);
  EXPECT_GT(likeness(lines, model), 90);
}

// Bugs put back, each seen to fail: what stands still in the light of the whole clip; Gaussians
// whose centre lies beyond a part left out of it.
TEST(WindowLines, StandInTheLightOfEach) {
  std::vector<FileWindow> windows = kTwoCores;
  windows[1].light = {0.6, 0.7, 0.8};
  const GaussianModel model = slow_clip();
  GaussianModel darker = model.clone_values();
  apply_light(windows[1].light, darker.static_set);
  const GaussianModel lines = lines_of_two(model, windows);
  EXPECT_EQ(lines.static_set.count(), 0);
  EXPECT_GT(likeness(lines, model, {0, 0.2, 0.35}), 43);
  EXPECT_GT(likeness(lines, darker, {0.6, 0.8, 1}), 43);
}

}  // namespace
}  // namespace tessera::testing
