// Groups of Gaussians that move rigidly: bodies that one node carries are exact, and the error of
// others is measured.
#include "static3d/transform/rigid_groups.h"

#include <gtest/gtest.h>

#include "kernels/math/rotation3.h"
#include "static3d/transform/lifetime_groups.h"
#include "static3d/transform/slicer.h"
#include "tests/support/travelling_camera.h"

namespace tessera::testing {
namespace {

const std::vector<double> kTimes = {0, 0.2, 0.4, 0.6, 0.8, 1};

/// The largest distance between a mean and its group's rigid motion at a time.
double farthest(const GaussianModel& model, const RigidGroups& groups, size_t time) {
  const GaussianSet slice = Slicer(model).at(kTimes[time]);
  double most = 0;
  for (const RigidGroup& group : groups.groups)
    for (const int64_t n : group.members) {
      const float* const x = groups.local.values().at(kMean, n);
      const float* const true_mean = slice.values().at(kMean, n);
      const Vec3<double> shown =
          rotation_matrix(group.poses[time].rotation) * Vec3<double>(x[0], x[1], x[2]) +
          group.poses[time].translation;
      for (int k = 0; k < 3; ++k) most = std::max(most, std::abs(shown[k] - double(true_mean[k])));
    }
  return most;
}

// Bug put back: the rotation of a group at the reference not taken out of its poses; seen to fail.
TEST(RigidGroups, ATurningBodyIsExact) {
  const GaussianModel model = turning_truth(2, {0.3, 0, 0.2});
  const RigidGroups groups = rigid_groups(model.static_set, model.nodes, kTimes);
  ASSERT_EQ(groups.groups.size(), 1u);
  EXPECT_EQ(groups.groups[0].members.size() + groups.fixed.size(),
            size_t(model.static_set.count()));
  EXPECT_EQ(groups.fixed.size(), 3u);
  EXPECT_LT(groups.rms_error, 1e-6);
  for (size_t t = 0; t < kTimes.size(); ++t) EXPECT_LT(farthest(model, groups, t), 2e-6) << t;
  EXPECT_GT(std::abs(groups.groups[0].poses[0].rotation[3]), 0.5) << "it turns";
}

// Bug put back: the error at the reference alone; seen to fail.
TEST(RigidGroups, TwoBodiesAreTwoGroups) {
  const GaussianModel model = meeting_truth(0.3f);
  const RigidGroups groups = rigid_groups(model.static_set, model.nodes, kTimes);
  ASSERT_EQ(groups.groups.size(), 2u);
  EXPECT_LT(groups.rms_error, 1e-6);
  const RigidGroups one = rigid_groups(model.static_set, model.nodes, kTimes, 1);
  ASSERT_EQ(one.groups.size(), 1u);
  EXPECT_GT(one.rms_error, 0.05) << "two bodies that part are no rigid one";
}

/// Two nodes that part, with Gaussians from one to the other along x.
GaussianModel bending() {
  GaussianModel model = meeting_truth(0.3f);
  const GaussianSpans<float> set = model.static_set.values();
  for (int64_t n = 0; n < set.count; ++n) {
    for (int k = 0; k < kBindings; ++k) {
      set.at(kNode, n)[k] = k < 2 ? float(k) : -1.0f;
      set.at(kNodeLogit, n)[k] = 0;
    }
    set.at(kMean, n)[0] = -0.6f + 1.2f * float(n) / float(set.count - 1);
  }
  model.nodes.log_radius.value[0] = model.nodes.log_radius.value[1] = std::log(0.5f);
  return model;
}

// Bugs put back: groups by the lightest node; no splits by pairs; the error at the reference alone;
// means not in the frame of the group. Each seen to fail.
TEST(RigidGroups, ABendingBodyHasAnErrorThatIsMeasured) {
  const GaussianModel model = bending();
  const RigidGroups groups = rigid_groups(model.static_set, model.nodes, kTimes);
  EXPECT_GT(groups.groups.size(), 2u) << "those between are groups of their own";
  EXPECT_GT(groups.rms_error, 1e-3);
  const RigidGroups two = rigid_groups(model.static_set, model.nodes, kTimes, 2);
  EXPECT_EQ(two.groups.size(), 2u);
  EXPECT_GT(two.rms_error, groups.rms_error);
  EXPECT_LT(farthest(model, groups, kTimes.size() / 2), 2e-6) << "exact at the reference";
}

// Bug put back: half of the visible interval without √(2 ln 2); seen to fail.
TEST(LifetimeGroups, AGroupIsVisibleWhereItsMarginalExceedsHalf) {
  std::vector<MovingGaussian> moving(4);
  for (size_t i = 0; i < 4; ++i) {
    moving[i].source = int64_t(i);
    moving[i].spacetime.precision_time = 1 / (0.1f * 0.1f);
    moving[i].spacetime.mean_time = 0.5f;
    moving[i].spacetime.velocity = {1, 0, 0};
  }
  moving[2].spacetime.mean_time = 3;  // after the clip
  moving[3].spacetime.precision_time = 1e-6f;
  moving[3].spacetime.velocity = {0, 0, 0};
  const LifetimeGroups groups = lifetime_groups(moving, 0, 1);
  EXPECT_EQ(groups.never_drawn, std::vector<int64_t>{2});
  EXPECT_EQ(groups.fixed, std::vector<int64_t>{3});
  ASSERT_EQ(groups.groups.size(), 1u);
  EXPECT_EQ(groups.groups[0].members, (std::vector<int64_t>{0, 1}));
  EXPECT_NEAR(groups.groups[0].begin, 0.5 - 0.117741, 1e-5);
  EXPECT_NEAR(groups.groups[0].end, 0.5 + 0.117741, 1e-5);
  EXPECT_NEAR(groups.groups[0].velocity[0], 1, 1e-9);
  EXPECT_NEAR(groups.rms_error, 0, 1e-9);
}

}  // namespace
}  // namespace tessera::testing
