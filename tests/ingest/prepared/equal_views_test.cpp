// Equal views are found within the noise of single precision, in any unit and order.
#include "ingest/prepared/equal_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>

#include "kernels/base/camera.h"

namespace tessera {
namespace {

/// A camera on a circle of radius `unit` that is turned by `angle`.
TransformsFrame frame_at(const std::string& name, double angle, double unit) {
  TransformsFrame frame;
  frame.name = name;
  const double c = std::cos(angle), s = std::sin(angle);
  frame.camera.cam_from_world = glm::dmat3(c, 0, s, 0, 1, 0, -s, 0, c);
  frame.camera.translation = {0, 0, unit};
  frame.intrinsics.fl_x = 500;
  return frame;
}

TransformsFrame rounded(TransformsFrame frame) {
  for (int c = 0; c < 3; ++c) {
    frame.camera.translation[c] = float(frame.camera.translation[c]);
    for (int r = 0; r < 3; ++r)
      frame.camera.cam_from_world[c][r] = float(frame.camera.cam_from_world[c][r]);
  }
  return frame;
}

// Bugs put back: views compared to the bit; a tolerance in world units; each seen to fail.
TEST(EqualViews, NoiseIsNoDifferenceInAnyUnit) {
  for (const double unit : {1e-6, 1.0, 1e6}) {
    const std::vector<TransformsFrame> frames = {
        frame_at("a", 0.3, unit), frame_at("b", 1.3, unit), rounded(frame_at("c", 0.3, unit)),
        frame_at("d", 0.301, unit), rounded(frame_at("e", 1.3, unit))};
    EXPECT_EQ(view_numbers(frames), (std::vector<int>{0, 1, 0, 2, 1})) << unit;
  }
}

TEST(EqualViews, IntrinsicsAndLensesCount) {
  std::vector<TransformsFrame> frames(5, frame_at("", 0.3, 1));
  for (size_t i = 0; i < frames.size(); ++i) frames[i].name = std::string(1, char('a' + i));
  frames[1].intrinsics.fl_x = 501;
  frames[2].lens.lens.k1 = 0.1;
  frames[3].intrinsics.fl_x.reset();
  EXPECT_EQ(view_numbers(frames), (std::vector<int>{0, 1, 2, 3, 0}));
}

TEST(EqualViews, NumbersFollowTheNames) {
  std::vector<TransformsFrame> frames = {frame_at("c", 0.1, 1), frame_at("b", 0.2, 1),
                                         frame_at("a", 0.1, 1)};
  EXPECT_EQ(view_numbers(frames), (std::vector<int>{0, 1, 0}));
  std::swap(frames[0], frames[1]);
  EXPECT_EQ(view_numbers(frames), (std::vector<int>{1, 0, 0}));
  EXPECT_TRUE(view_numbers({}).empty());
}

}  // namespace
}  // namespace tessera
