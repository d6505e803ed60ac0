// Trainings with motion nodes: they reconstruct a body around which one camera travels, resume bit
// by bit, and have no effect on static scenes.
#include <gtest/gtest.h>

#include "tests/support/resume.h"
#include "tests/support/travelling_camera.h"

namespace tessera::testing {
namespace {

TrainOptions node_options(int64_t iterations) {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = iterations;
  options.batch = 1;
  options.init_points = 120;
  options.init_extent = 0.9;
  options.static_fraction = 0;
  options.sh_degree = 0;
  options.densify_from = iterations / 6;
  options.densify_until = iterations / 2;
  options.densify_interval = iterations / 12;
  options.max_gaussians = 200;
  options.motion = Motion::kNodes;
  options.motion_nodes = 16;
  options.nodes_from = iterations / 10;
  options.node_knot_interval = iterations / 4;
  options.node_knots = 8;
  return options;
}

/// Median of three seeds.
double test_psnr(const Scene& scene, TrainOptions options) {
  std::vector<double> psnr;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    Training training(scene, options);
    training.run();
    psnr.push_back(psnr_of(training.backend(), training.model(), scene, Split::kTest));
  }
  std::sort(psnr.begin(), psnr.end());
  return psnr[1];
}

/// Motion from an early step on, of points that are opaque enough for nodes.
TrainOptions early_options(int64_t iterations) {
  TrainOptions options = node_options(iterations);
  options.nodes_from = 30;
  options.init_opacity = 0.3;
  return options;
}

/// Test views are better by `gain` dB with nodes than with dynamic Gaussians. Returns the score
/// with nodes, dB.
double expect_nodes_gain(const Scene& scene, TrainOptions options, double gain) {
  const double nodes = test_psnr(scene, options);
  options.motion = Motion::kPair;
  const double dynamic = test_psnr(scene, options);
  EXPECT_GT(nodes, dynamic + gain) << "dynamic " << dynamic;
  return nodes;
}

/// Half a turn in 48 images: a dynamic Gaussian sees a few of them, a canonical one sees all.
// Bug put back: nodes that are not stepped; seen to fail.
TEST(MotionTraining, SeesAroundATurningBody) {
  const Scene scene = travelling_camera(turning_truth(3, {0.3, 0.2, 0}), 48, 24);
  TrainOptions options = early_options(1500);
  const double nodes = expect_nodes_gain(scene, options, 1);
  options.motion = Motion::kNone;
  const double still = test_psnr(scene, options);
  EXPECT_GT(nodes, still + 5) << "static " << still;
}

/// Once around in 60 images: the last frame is the first again, and rotations have no seam.
// Bug put back: rotations of nodes that are not stepped; seen to fail.
TEST(MotionTraining, SeesAroundABodyThatTurnsOnceAround) {
  expect_nodes_gain(travelling_camera(turning_truth(2 * M_PI, {0, 0, 0}), 60, 24),
                    early_options(4000), 3);
}

/// Two bodies that meet in the middle of the clip and part again: Gaussians of one are not torn
/// away by the other.
// Bug put back: nodes that are not stepped; seen to fail.
TEST(MotionTraining, BodiesThatTouchAndPart) {
  expect_nodes_gain(travelling_camera(meeting_truth(0.3f), 48, 24), early_options(1500), 3);
}

// Bug put back: control points and their optimizer state left out of the checkpoint; seen to fail.
TEST(MotionTraining, ResumesBitByBit) {
  const Scene scene = travelling_camera(turning_truth(0.8, {0.2, 0, 0}), 48, 12);
  for (const bool fused : {true, false}) {
    TrainOptions options = node_options(48);
    options.fused_optimizer = fused;
    Training whole(scene, options);
    whole.run();
    EXPECT_EQ(whole.model().nodes.knots, 8);
    // before motion starts, with 5 control points, and with 8
    for (const int64_t half : {3, 10, 30})
      expect_resumes(scene, options, half, whole, [&](const TrainState& state) {
        EXPECT_EQ(state.model.nodes.empty(), half < 4);
      });
  }
}

TEST(MotionTraining, FusedAndSeparateOptimizersAgree) {
  const Scene scene = travelling_camera(turning_truth(0.8, {0.2, 0, 0}), 12, 12);
  TrainOptions options = node_options(24);
  options.densify_until = 0;
  Training fused(scene, options);
  fused.run();
  options.fused_optimizer = false;
  Training separate(scene, options);
  separate.run();
  EXPECT_EQ(state_bits(fused.state()), state_bits(separate.state()));
  EXPECT_FALSE(fused.model().nodes.empty());
}

TEST(MotionTraining, ControlPointsFollowTheOptions) {
  const Scene scene = travelling_camera(turning_truth(0.8, {0.2, 0, 0}), 48, 8);
  TrainOptions options = node_options(24);
  const auto knots = [&] { return Training(scene, options).run().model().nodes.knots; };
  EXPECT_EQ(knots(), 8);
  options.node_knots = 6;
  EXPECT_EQ(knots(), 6);
  options.node_knots = 14;  // at most one for four timesteps
  EXPECT_EQ(knots(), 12);
  options.node_knot_interval = 1000;
  EXPECT_EQ(knots(), 5);
}

TEST(MotionTraining, OneTimestepHasNoNodes) {
  const Scene scene = tiny_capture({.cameras = 6, .timesteps = 1});
  TrainOptions options = tiny_options();
  Training without(scene, options);
  without.run();
  options.motion_nodes = 8;
  options.nodes_from = 5;
  Training with(scene, options);
  with.run();
  EXPECT_EQ(state_bits(with.state()), state_bits(without.state()));
}

TEST(MotionTraining, AClipOfTwoFrames) {
  const Scene scene = travelling_camera(turning_truth(0.3, {0.1, 0, 0}), 2, 16);
  TrainOptions options = node_options(60);
  Training training(scene, options);
  training.run();
  EXPECT_EQ(training.model().nodes.knots, 5);
  EXPECT_TRUE(std::isfinite(training.psnr()));
}

}  // namespace
}  // namespace tessera::testing
