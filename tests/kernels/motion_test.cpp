// Poses of motion nodes and the Gaussians carried by them: the spline, motions with a known answer,
// and gradients against dual numbers.
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "kernels/math/carry.h"
#include "tests/support/compare.h"
#include "tests/support/dual.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

constexpr double kTolerance = 1e-12;  // some hundred roundings of numbers of order 1
constexpr int kKnots = 6;

template <class Real, size_t N>
Vec3<Real> vec3(const std::array<Real, N>& p, size_t first = 0) {
  return Vec3<Real>(p[first], p[first + 1], p[first + 2]);
}
template <class Real, size_t N>
Vec4<Real> vec4(const std::array<Real, N>& p, size_t first = 0) {
  return Vec4<Real>(p[first], p[first + 1], p[first + 2], p[first + 3]);
}

/// A rotation about z by an angle in radians.
Vec4<double> about_z(double angle) {
  return {std::cos(angle / 2), 0, 0, std::sin(angle / 2)};
}

NodePose<double> pose_of(const Vec4<double>& quaternion, const Vec3<double>& translation) {
  return {rotation_matrix(quaternion), translation, quaternion};
}

Binding<double> bound_to(std::vector<int> nodes, std::vector<double> weights) {
  Binding<double> binding;
  for (int k = 0; k < kBindings; ++k) {
    binding.node[k] = k < int(nodes.size()) ? nodes[size_t(k)] : -1;
    binding.weight[k] = k < int(nodes.size()) ? weights[size_t(k)] : 0;
  }
  return binding;
}

TEST(MotionSpline, WeightsAreThoseOfTheDefinition) {
  for (const int knots : {4, 5, 14})
    for (double t = 0; t <= 1; t += 1.0 / 64) {
      const SplineWeights<double> s = spline_weights(t, knots);
      ASSERT_GE(s.first, 0);
      ASSERT_LE(s.first + kSplineOrder, knots);
      for (int i = 0; i < knots; ++i) {
        const double a = std::abs(t * (knots - 3) + 1 - i);
        const double expected = a < 1   ? 2.0 / 3 - a * a + a * a * a / 2
                                : a < 2 ? (2 - a) * (2 - a) * (2 - a) / 6
                                        : 0;
        const int j = i - s.first;
        EXPECT_NEAR(j >= 0 && j < kSplineOrder ? s.weight[j] : 0, expected, kTolerance)
            << "knots " << knots << ", time " << t << ", control point " << i;
      }
    }
}

TEST(MotionSpline, TimesOutsideOfTheClipAreItsEnds) {
  for (const auto& [outside, end] : {std::pair{-0.5, 0.0}, std::pair{1.5, 1.0}}) {
    const SplineWeights<double> s = spline_weights(outside, kKnots),
                                last = spline_weights(end, kKnots);
    EXPECT_EQ(s.first, last.first);
    for (int i = 0; i < kSplineOrder; ++i) EXPECT_EQ(s.weight[i], last.weight[i]);
  }
}

/// Control points on the half circle of quaternions: one turn about z around the node.
TEST(MotionSpline, ANodeTurnsOnceAroundWithoutASeam) {
  constexpr int knots = 14;
  std::vector<double> rotation, translation(3 * knots, 0.0);
  for (int i = 0; i < knots; ++i) {
    const Vec4<double> q = about_z(2 * std::numbers::pi * (i - 1) / (knots - 3));
    rotation.insert(rotation.end(), {q[0], q[1], q[2], q[3]});
  }
  const Vec3<double> position(3, -1, 2), arm(1, 0, 0);
  const auto tip = [&](double t) {
    const NodePose<double> pose =
        node_pose(position, spline_weights(t, knots), translation.data(), rotation.data());
    return pose.rotation * (position + arm) + pose.translation - position;
  };
  for (int k = 0; k <= knots - 3; ++k) {  // at its knots the spline is on the circle
    const double angle = 2 * std::numbers::pi * k / (knots - 3);
    const Vec3<double> place = tip(double(k) / (knots - 3));
    EXPECT_NEAR(place[0], std::cos(angle), kTolerance);
    EXPECT_NEAR(place[1], std::sin(angle), kTolerance);
  }
  Vec3<double> before = tip(0);
  for (int k = 1; k <= 1000; ++k) {
    const Vec3<double> now = tip(k / 1000.0), step = now - before;
    EXPECT_NEAR(std::sqrt(dot(step, step)), 2 * std::numbers::pi / 1000, 1e-4) << k;
    before = now;
  }
}

TEST(MotionSpline, PoseBackwardEqualsDuals) {
  Random random(1);
  constexpr size_t controls = 7 * kKnots;
  for (const double t : {0.0, 0.3, 0.62, 1.0}) {
    const auto x = random.array<controls>(-1, 1);
    const auto p = random.array<3>(-2, 2);
    const auto weight = random.array<16>(-1, 1);
    const auto expected = dual_gradient(x, [&](const auto& c) {
      const Vec3<Dual> position(p[0], p[1], p[2]);
      const NodePose<Dual> pose =
          node_pose(position, spline_weights(Dual(t), kKnots), c.data(), c.data() + 3 * kKnots);
      Dual loss = 0;
      for (int i = 0; i < 9; ++i) loss += pose.rotation[i / 3][i % 3] * weight[size_t(i)];
      for (int i = 0; i < 3; ++i) loss += pose.translation[i] * weight[size_t(9 + i)];
      for (int i = 0; i < 4; ++i) loss += pose.quaternion[i] * weight[size_t(12 + i)];
      return loss;
    });
    NodePose<double> d_pose;
    for (int i = 0; i < 9; ++i) d_pose.rotation[i / 3][i % 3] = weight[size_t(i)];
    d_pose.translation = vec3(weight, 9);
    d_pose.quaternion = vec4(weight, 12);
    const SplineWeights<double> s = spline_weights(t, kKnots);
    const NodeGradient<double> d = node_pose_backward(vec3(p), s, x.data() + 3 * kKnots, d_pose);
    std::array<double, controls> actual{};
    for (int i = 0; i < kSplineOrder; ++i) {
      for (int c = 0; c < 3; ++c)
        actual[size_t(3 * (s.first + i) + c)] = s.weight[i] * d.translation[c];
      for (int c = 0; c < 4; ++c)
        actual[size_t(3 * kKnots + 4 * (s.first + i) + c)] = s.weight[i] * d.rotation[c];
    }
    expect_near_all(actual, expected, kTolerance, "d_control");
  }
}

TEST(MotionSpline, ControlPointsThatBlendToNothingLeaveTheNodeUnturned) {
  const std::vector<double> none(4 * kKnots, 0.0), translation(3 * kKnots, 0.25);
  const SplineWeights<double> s = spline_weights(0.4, kKnots);
  const NodePose<double> pose =
      node_pose(Vec3<double>(1, 2, 3), s, translation.data(), none.data());
  EXPECT_EQ(pose.quaternion, Vec4<double>(1, 0, 0, 0));
  EXPECT_NEAR(pose.translation[0], 0.25, kTolerance);
  NodePose<double> d_pose = pose;
  EXPECT_EQ(node_pose_backward(Vec3<double>(1, 2, 3), s, none.data(), d_pose).rotation,
            Vec4<double>(0.0));
}

TEST(MotionSpline, SecondDifferenceGradientEqualsDuals) {
  Random random(2);
  const auto x = random.array<kKnots>(-1, 1);
  const auto expected = dual_gradient(x, [&](const auto& c) {
    Dual sum = 0;
    for (size_t j = 1; j + 1 < kKnots; ++j) {
      const Dual bend = c[j - 1] - Dual(2) * c[j] + c[j + 1];
      sum += bend * bend;
    }
    return sum;
  });
  std::array<double, kKnots> actual;
  for (int i = 0; i < kKnots; ++i)
    actual[size_t(i)] = second_difference_gradient(x.data(), kKnots, 1, i);
  expect_near_all(actual, expected, kTolerance, "d_control");
}

TEST(MotionCarry, WeightsAreASoftmaxOverTheNodesThatAreBound) {
  const double logit[kBindings] = {0.5, -1, 9, 0.25}, distance2[kBindings] = {1, 0.25, 0, 4},
               falloff[kBindings] = {node_falloff(0.0), node_falloff(-0.5), 1, node_falloff(1.0)};
  Binding<double> binding = bound_to({4, 0, -1, 2}, {0, 0, 0, 0});
  binding_weights(logit, falloff, distance2, binding);
  const double e0 = std::exp(0.5 - 0.5), e1 = std::exp(-1 - 0.5 * std::exp(1.0) * 0.25),
               e3 = std::exp(0.25 - 0.5 * std::exp(-2.0) * 4), sum = e0 + e1 + e3;
  EXPECT_NEAR(binding.weight[0], e0 / sum, kTolerance);
  EXPECT_NEAR(binding.weight[1], e1 / sum, kTolerance);
  EXPECT_EQ(binding.weight[2], 0);
  EXPECT_NEAR(binding.weight[3], e3 / sum, kTolerance);

  Binding<double> none = bound_to({}, {});
  binding_weights(logit, falloff, distance2, none);
  for (int k = 0; k < kBindings; ++k) EXPECT_EQ(none.weight[k], 0);
}

/// Also where every logit is so low that its exponential is 0.
TEST(MotionCarry, WeightsOfFarNodesAreFinite) {
  const double logit[kBindings] = {-2000, -2001}, falloff[kBindings] = {1, 1},
               distance2[kBindings] = {1e6, 1e6};
  Binding<double> binding = bound_to({0, 1}, {0, 0});
  binding_weights(logit, falloff, distance2, binding);
  EXPECT_NEAR(binding.weight[0], 1 / (1 + std::exp(-1.0)), kTolerance);
}

TEST(MotionCarry, WeightsBackwardEqualsDuals) {
  Random random(3);
  const auto distance2 = random.array<kBindings>(0, 2);
  const auto weight = random.array<kBindings>(-1, 1);
  const auto x = random.array<2 * kBindings>(-1, 1);  // logits and ln r
  const std::vector<int> nodes = {3, 1, -1, 0, 2, 5, -1, 4};
  const auto run = [&]<class Real>(const std::array<Real, 2 * kBindings>& p,
                                   Binding<Real>& binding) {
    Real falloff[kBindings], at[kBindings];
    for (int k = 0; k < kBindings; ++k) {
      binding.node[k] = nodes[size_t(k)];
      falloff[k] = node_falloff(p[size_t(kBindings + k)]);
      at[k] = Real(distance2[size_t(k)]);
    }
    binding_weights(p.data(), falloff, at, binding);
  };
  const auto expected = dual_gradient(x, [&](const auto& p) {
    Binding<Dual> binding;
    run(p, binding);
    Dual loss = 0;
    for (int k = 0; k < kBindings; ++k) loss += binding.weight[k] * weight[size_t(k)];
    return loss;
  });
  Binding<double> binding;
  run(x, binding);
  std::array<double, 2 * kBindings> actual;
  binding_weights_backward(binding, weight.data(), actual.data());
  for (size_t k = 0; k < kBindings; ++k)
    actual[kBindings + k] = 2 * node_falloff(x[kBindings + k]) * distance2[k] * actual[k];
  expect_near_all(actual, expected, kTolerance, "d_logit, d_log_radius");
}

TEST(MotionCarry, OneNodeMovesAsARigidBody) {
  const Vec4<double> q = normalised(Vec4<double>(1, 0.4, -0.3, 0.7));
  const Vec3<double> shift(0.5, -2, 1), mean(1, 2, 3);
  const std::vector<NodePose<double>> poses = {pose_of(about_z(1), Vec3<double>(9.0)),
                                               pose_of(q, shift)};
  for (const auto& binding :
       {bound_to({1}, {1}), bound_to({0, 1}, {0, 1}), bound_to({1, 1, 1}, {0.5, 0.25, 0.25})}) {
    const Carry<double> c = blend_poses(binding, poses.data());
    const Vec3<double> expected = rotation_matrix(q) * mean + shift;
    const Vec4<double> rotation(0.3, 0.1, -0.2, 0.9);
    const Mat3<double> turned = rotation_matrix(carried_rotation(c, rotation));
    const Mat3<double> both = rotation_matrix(q) * rotation_matrix(rotation);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(carried_mean(c, mean)[i], expected[i], kTolerance);
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(turned[i][j], both[i][j], kTolerance);
    }
  }
}

/// q and −q are one rotation: a node that has turned once more than its neighbour moves nothing.
TEST(MotionCarry, SignsOfQuaternionsDoNotMatter) {
  const Vec4<double> a = about_z(0.2), b = about_z(0.4), rotation(1, 0, 0, 0);
  const std::vector<NodePose<double>> poses = {
      pose_of(a, Vec3<double>(0.0)), pose_of(b, Vec3<double>(0.0)), pose_of(-b, Vec3<double>(0.0))};
  const Carry<double> same = blend_poses(bound_to({0, 1}, {0.75, 0.25}), poses.data());
  const Carry<double> other = blend_poses(bound_to({0, 2}, {0.75, 0.25}), poses.data());
  EXPECT_TRUE(other.flipped[1]);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(carried_rotation(same, rotation)[i], carried_rotation(other, rotation)[i],
                kTolerance);
}

TEST(MotionCarry, BackwardEqualsDuals) {
  Random random(4);
  for (int round = 0; round < 10; ++round) {
    std::vector<NodePose<double>> poses;
    for (int m = 0; m < 6; ++m)
      poses.push_back(
          pose_of(normalised(vec4(random.array<4>(-1, 1))), vec3(random.array<3>(-1, 1))));
    const std::vector<int> nodes = {3, 1, -1, 0, 2, 5, -1, 4};
    // the mean and the rotation at rest, the weights, and every number of the poses
    constexpr size_t inputs = 7 + kBindings + 6 * 16;
    auto x = random.array<inputs>(-1, 1);
    for (size_t k = 0; k < kBindings; ++k) x[7 + k] = nodes[k] < 0 ? 0 : 0.1 + std::abs(x[7 + k]);
    for (size_t m = 0; m < poses.size(); ++m)
      for (size_t i = 0; i < 16; ++i)
        x[7 + kBindings + 16 * m + i] = i < 9    ? poses[m].rotation[int(i) / 3][int(i) % 3]
                                        : i < 12 ? poses[m].translation[int(i) - 9]
                                                 : poses[m].quaternion[int(i) - 12];
    const auto g = random.array<7>(-1, 1);
    const auto expected = dual_gradient(x, [&](const auto& p) {
      Binding<Dual> binding;
      for (int k = 0; k < kBindings; ++k) {
        binding.node[k] = nodes[size_t(k)];
        binding.weight[k] = p[size_t(7 + k)];
      }
      std::vector<NodePose<Dual>> at(poses.size());
      for (size_t m = 0; m < poses.size(); ++m) {
        const size_t first = 7 + kBindings + 16 * m;
        for (size_t i = 0; i < 9; ++i) at[m].rotation[int(i) / 3][int(i) % 3] = p[first + i];
        at[m].translation = vec3(p, first + 9);
        at[m].quaternion = vec4(p, first + 12);
      }
      const Carry<Dual> c = blend_poses(binding, at.data());
      const Vec3<Dual> mean = carried_mean(c, vec3(p));
      const Vec4<Dual> rotation = carried_rotation(c, vec4(p, 3));
      Dual loss = 0;
      for (int i = 0; i < 3; ++i) loss += mean[i] * g[size_t(i)];
      for (int i = 0; i < 4; ++i) loss += rotation[i] * g[size_t(3 + i)];
      return loss;
    });
    Binding<double> binding;
    for (int k = 0; k < kBindings; ++k) {
      binding.node[k] = nodes[size_t(k)];
      binding.weight[k] = x[size_t(7 + k)];
    }
    const Carry<double> c = blend_poses(binding, poses.data());
    const Vec3<double> d_mean = vec3(g);
    const CarryGradient<double> d =
        carry_backward(binding, poses.data(), c, vec3(x), vec4(x, 3), d_mean, vec4(g, 3));
    std::array<double, inputs> actual{};
    for (int i = 0; i < 3; ++i) actual[size_t(i)] = d.mean[i];
    for (int i = 0; i < 4; ++i) actual[size_t(3 + i)] = d.rotation[i];
    for (int k = 0; k < kBindings; ++k) {
      actual[size_t(7 + k)] = d.weight[k];
      if (nodes[size_t(k)] < 0) continue;
      double* const pose = &actual[7 + kBindings + 16 * size_t(nodes[size_t(k)])];
      const NodePose<double> share =
          node_share(binding.weight[k], c.flipped[k], vec3(x), d_mean, d.turn);
      for (int i = 0; i < 9; ++i) pose[i] += share.rotation[i / 3][i % 3];
      for (int i = 0; i < 3; ++i) pose[9 + i] += share.translation[i];
      for (int i = 0; i < 4; ++i) pose[12 + i] += share.quaternion[i];
    }
    expect_near_all(actual, expected, kTolerance, "gradients of a carried Gaussian");
  }
}

}  // namespace
}  // namespace tessera::testing
