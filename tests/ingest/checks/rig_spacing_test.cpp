// What new views to expect of a rig, and the gap that a further camera should fill.
#include "ingest/checks/rig_spacing.h"

#include <gtest/gtest.h>

#include "tests/ingest/checks/checks_fixture.h"

namespace tessera::testing {
namespace {

/// Those cameras of a ring of twelve, 30 degrees apart.
std::vector<Station> of_ring(const std::vector<int>& cameras) {
  const std::vector<Station> all = training_stations(ring_scene({.cameras = 12, .timesteps = 1}));
  std::vector<Station> some;
  for (const int camera : cameras) some.push_back(all[size_t(camera)]);
  return some;
}

void expect_says(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
}

// Bugs put back: the ends of an arc taken for a gap; the first gap in place of the widest; each
// seen to fail.
TEST(RigSpacing, TheWidestGapLiesBetweenNeighbours) {
  const RigSpacing rig = rig_spacing(of_ring({5, 0, 1, 3, 4}));
  EXPECT_EQ(rig.cameras, 5);
  EXPECT_EQ(rig.gap[0], "cam1");
  EXPECT_EQ(rig.gap[1], "cam3");
  EXPECT_NEAR(rig.gap_angle, 60, 1e-6);
  EXPECT_NEAR(rig.angle, 60, 1e-6) << "of second neighbours 60, 60, 60, 60, 90";
  EXPECT_TRUE(rig_spacing(of_ring({0})).gap[0].empty());
}

// Bug put back: test views said to be there where all cameras train; seen to fail.
TEST(RigSpacing, FewCamerasSayWhatToExpect) {
  const auto expected = [](const std::vector<int>& cameras, bool held_out) {
    return expected_views(of_ring(cameras), held_out);
  };
  const auto four = expected({0, 1, 2, 4}, true);
  ASSERT_TRUE(four);
  EXPECT_EQ(four->severity, Severity::kWarning);
  expect_says(four->measured, {"4 training cameras", "neighbours 60 degrees apart", " dB"});
  expect_says(four->advice, {"between cam2 and cam4, 60 degrees", "--held-out none"});
  EXPECT_EQ(expected({0, 1, 2, 4}, false)->advice.find("--held-out"), std::string::npos);
  EXPECT_NE(expected({0, 1, 2}, true)->measured, four->measured);
  const auto six = expected({0, 1, 2, 3, 4, 5}, true);
  ASSERT_TRUE(six);
  EXPECT_EQ(six->severity, Severity::kInfo);
  EXPECT_FALSE(expected({0, 1, 2, 3, 4, 5, 6, 7}, true));
  ASSERT_TRUE(expected({0}, false));
  expect_says(expected({0}, false)->measured, {"1 training camera:"});
}

}  // namespace
}  // namespace tessera::testing
