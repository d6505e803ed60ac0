// Every row of the option table has an effect: another legal value trains another model. A row
// without an entry below fails.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/cloud/dense_cloud.h"
#include "recon4d/options/train_options.h"
#include "recon4d/options/train_options_json.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

/// Wide enough for points that no camera sees, small enough for Gaussians that are too large.
TrainOptions usual_options() {
  TrainOptions options = tiny_options();
  options.init_points = 80;
  options.init_extent = 3;
  options.prune_extent = 0.05;
  return options;
}

/// A legal value that differs from usual_options().
struct Alternative {
  const char* key;
  json value;
  json with = json::object();  // set in both; then by a narrow rig, with a cloud swept from it
  bool behind = false;         // by images without alpha, and for all but itself before a map
};

/// Motion nodes from an early step on.
const json kNodes = {
    {"motion", "nodes"}, {"motion_nodes", 6}, {"nodes_from", 8}, {"init_opacity", 0.3}};

const std::vector<Alternative>& alternatives() {
  static const std::vector<Alternative> rows = {
      {"iterations", 36},
      {"schedule_iterations", 80},
      {"batch", 3},
      {"seed", 7},
      {"motion", "velocity"},
      {"background", "white"},
      {"near_plane", 3.9},
      {"clear_distance", 3.9},
      {"far_plane", 4.1},
      {"init_points", 50},
      {"init_extent", 0},
      {"init_opacity", 0.2},
      {"init_scale_factor", 0.5},
      {"init_time_scale", 0.3},
      {"static_fraction", 0.25},
      {"carve", false},
      {"split_by_motion", true, {{"init_points", 400}, {"max_gaussians", 400}}},
      {"sh_degree", 2},
      {"sh_interval", 12},
      {"sh_time_degree", 1},
      {"sliced_direction", false},
      {"filter_2d", true},
      {"filter_3d", "mip"},
      {"truncation_sigma", 2.5},
      {"truncation_by_falloff", true},
      {"time_filter", 0.05},
      {"lambda_dssim", 0.5},
      {"moving_weight", 4},
      {"opacity_weight", 0.01},
      {"scale_weight", 0.01},
      {"environment", true, json::object(), true},
      {"environment_size", 8, json::object(), true},
      {"lr_environment", 0.02, json::object(), true},
      {"clocks", "learn"},
      {"learn_readouts", true},
      {"lr_clocks", 0.05, {{"clocks", "learn"}}},
      {"exposure", "camera"},
      {"lr_exposure", 0.05, {{"exposure", "frame"}}},
      {"lr_mean", 3e-4},
      {"lr_mean_final", 1.6e-4},
      {"lr_mean_time", 3e-4},
      {"lr_scale", 1e-2},
      {"lr_scale_time", 1e-2},
      {"lr_rotation", 1e-2},
      {"lr_velocity", 2e-3, {{"motion", "velocity"}}},
      {"lr_opacity", 0.02},
      {"lr_sh", 1e-2},
      {"lr_sh_rest", 1e-3},
      {"densification", "mcmc", {{"max_gaussians", 90}}},
      {"budget_without", "long-axis-split", {{"max_gaussians", 400}, {"densification", "budget"}}},
      {"mcmc_noise", 1e5, {{"max_gaussians", 90}, {"densification", "mcmc"}}},
      {"mcmc_growth", 1.2, {{"max_gaussians", 90}, {"densification", "mcmc"}}},
      {"densify_from", 18},
      {"densify_until", 18},
      {"densify_interval", 9},
      {"densify_threshold", 1e-2},
      {"static_threshold", 100.0},
      {"static_halves", true},
      {"noise", 60.0},
      {"dense_fraction", 0.2},
      {"prune_opacity", 0.1},
      {"prune_extent", 0.08},
      {"prune_large_from", 29},
      {"opacity_reset_interval", 10},
      {"max_gaussians", 70},
      {"peak_gaussians", 70},
      {"min_blending_weight", 0.2, {{"unseen_interval", 10}}},
      {"unseen_interval", 7, {{"min_blending_weight", 0.2}}},
      {"reorder_interval", 0},
      {"average_from", 0.5},
      {"idle_updates", "skip"},
      {"motion_nodes", 8, kNodes},
      {"nodes_from", 12, kNodes},
      {"lr_node_translation", 1e-2, kNodes},
      {"lr_node_rotation", 1e-2, kNodes},
      {"lr_node_decay", 0.5, kNodes},
      {"lr_node_logit", 0.1, kNodes},
      {"lr_node_radius", 0.1, kNodes},
      {"node_acceleration", 10, kNodes},
  };
  return rows;
}

/// Rows that change how something is done, and must not change the model of a CPU: its gradients
/// are added in one order. What a device makes of the kernels' switches is the subject of its
/// tests.
const std::vector<Alternative>& same_models() {
  static const std::vector<Alternative> rows = {
      {"fused_optimizer", false}, {"balanced_instances", false}, {"separate_sort", false},
      {"warp_culling", false},    {"backward", "pixel"},         {"deterministic", true},
      {"feed_bytes", 1000},
  };
  return rows;
}

/// Rows that act on the scene or the options before a training: CliSweep.CompletesAScene,
/// CliScales.AreScoredAgainstTruthOfTheirSize, ShownPixels.LimitTheGaussians.
const char* const kBeforeTraining[] = {"sweep", "train_scale", "gaussians_per_pixel"};

/// Rows that need more timesteps than a tiny capture has:
/// MotionTraining.ControlPointsFollowTheOptions.
const char* const kOfLongClips[] = {"node_knots", "node_knot_interval"};

/// Rows that list splats in more tiles, which the instances of a step show.
const char* const kBounds[] = {"rectangular_bounds", "opacity_bounds"};

/// Rows that decide which model is kept and when training ends; with what makes that seen.
const std::vector<Alternative>& of_validation() {
  static const std::vector<Alternative> rows = {
      {"validation_share", 0.5},
      {"validate_interval", 5},
      {"stop_patience", 2, {{"lr_mean", 0.05}, {"lr_scale", 0.2}, {"lr_sh", 0.2}}},
  };
  return rows;
}

/// Rows that thin out and move between the sets; with what makes that seen.
const std::vector<Alternative>& of_reduction() {
  static const std::vector<Alternative> rows = {
      {"size", "knee", {{"size", "grown"}}},
      {"max_bytes", 2000},
      {"within_db", 0.5},
      {"thin_rounds", 2},
      {"thin_until", 36},
      {"decide_motion", true},
      {"spawn_missed", true, {{"decide_motion", true}, {"moving_weight", 4}}},
      {"decide_colour", true},
      {"decide_interval", 4, {{"decide_motion", true}}},
  };
  return rows;
}

/// The last state of a training that decides.
std::vector<uint32_t> decided(const TrainOptions& options) {
  validate(options);
  const Scene scene = tiny_capture();
  Training training(scene, options);
  Validation validation(training.backend(), scene, options);
  ModelReduction reduction(training.backend(), options,
                           [](const GaussianModel& model) { return 50 * model.count(); });
  training.run(options.iterations, reduction, validation);
  return state_bits(training.state());
}

/// The model that is kept, and the steps until then and until the end.
std::vector<uint32_t> kept(const TrainOptions& options) {
  Scene scene = tiny_capture();
  hold_out_validation(scene, options.validation_share, uint64_t(options.seed));
  Training training(scene, options);
  Validation validation(training.backend(), scene, options);
  training.run(options.iterations, validation);
  std::vector<uint32_t> bits = model_bits(*validation.best());
  for (int64_t steps : {validation.record().checks, training.state().iteration})
    bits.push_back(uint32_t(steps));
  return bits;
}

/// The scene depends on the background as a folder of RGBA frames does.
std::vector<uint32_t> trained(const TrainOptions& options, bool narrow = false,
                              bool behind = false) {
  validate(options);
  TinyCapture capture{.background = parse_background(options.background)};
  if (narrow) capture.arc = 0.5;  // cameras near enough for patches to be compared
  Scene scene = tiny_capture(capture);
  scene.had_alpha = !behind;
  if (narrow)
    scene.points = cloud_of(dense_points(PlaneSweep(scene), {options.init_points, 1, {}}));
  Training training(scene, options);
  return model_bits(training.run().model());
}

/// Tile instances of the last step before density control, of images of several tiles.
int64_t some_instances(const std::string& key, bool value) {
  const Scene scene = tiny_capture({.size = 100});
  TrainOptions options = usual_options();
  set_option_from_json(options, key, value);
  Training training(scene, options);
  return training.run(options.densify_from).steps().back().instances;
}

class Switch : public ::testing::TestWithParam<std::string> {};

// Bug put back: rotations are trained at a fixed rate (lr_rotation); seen to fail.
TEST_P(Switch, ChangesTheModel) {
  TrainOptions options = usual_options();
  for (const Alternative& row : same_models())
    if (GetParam() == row.key) {
      set_option_from_json(options, row.key, row.value);
      EXPECT_NE(to_json(options), to_json(usual_options()));
      EXPECT_TRUE(trained(options) == trained(usual_options()));
      return;
    }
  for (const char* key : kBounds)
    if (GetParam() == key) {
      EXPECT_GT(some_instances(key, false), some_instances(key, true));
      return;
    }
  for (const char* key : kOfLongClips)
    if (GetParam() == key) GTEST_SKIP() << "needs more timesteps";
  for (const char* key : kBeforeTraining)
    if (GetParam() == key) GTEST_SKIP() << "acts before training";
  for (const Alternative& row : of_validation())
    if (GetParam() == row.key) {
      options.validation_share = 0.25;
      options.validate_interval = 4;
      for (const auto& [key, value] : row.with.items()) set_option_from_json(options, key, value);
      const std::vector<uint32_t> usual = kept(options);
      set_option_from_json(options, row.key, row.value);
      EXPECT_TRUE(kept(options) != usual) << row.key << " = " << row.value << " is dead";
      return;
    }
  for (const Alternative& row : of_reduction())
    if (GetParam() == row.key) {
      options.size = ModelSize::kKnee;
      options.densify_until = 18;
      options.thin_until = 30;
      options.thin_rounds = 3;
      options.decide_interval = 6;
      for (const auto& [key, value] : row.with.items()) set_option_from_json(options, key, value);
      const std::vector<uint32_t> usual = decided(options);
      set_option_from_json(options, row.key, row.value);
      EXPECT_TRUE(decided(options) != usual) << row.key << " = " << row.value << " is dead";
      return;
    }
  for (const Alternative& row : alternatives())
    if (GetParam() == row.key) {
      const bool narrow = !row.with.empty();
      for (const auto& [key, value] : row.with.items()) set_option_from_json(options, key, value);
      options.environment = row.behind && GetParam() != "environment";
      const std::vector<uint32_t> usual = trained(options, narrow, row.behind);
      const json before = to_json(options)[row.key];
      set_option_from_json(options, row.key, row.value);
      EXPECT_NE(to_json(options)[row.key], before);
      EXPECT_TRUE(trained(options, narrow, row.behind) != usual)
          << row.key << " = " << row.value << " is dead";
      return;
    }
  FAIL() << GetParam() << " has no alternative value in this test";
}

/// Each row of KernelSwitches reaches its own member, and defaults are the kernels'.
// Bug put back: separate_sort read from balanced_instances; seen to fail.
TEST(KernelOptions, EachSwitchHasItsOwnField) {
  const auto bits = [](const TrainOptions& options) {
    const KernelSwitches k = kernel_switches(options);
    return std::vector<int>{k.bounds.rectangular, k.bounds.opacity_aware, k.balanced_instances,
                            k.separate_sort,      k.warp_culling,         int(k.backward),
                            k.deterministic};
  };
  const KernelSwitches usual;
  EXPECT_EQ(bits({}),
            (std::vector<int>{usual.bounds.rectangular, usual.bounds.opacity_aware,
                              usual.balanced_instances, usual.separate_sort, usual.warp_culling,
                              int(usual.backward), usual.deterministic}));
  const char* const keys[] = {"rectangular_bounds", "opacity_bounds", "balanced_instances",
                              "separate_sort",      "warp_culling",   "backward",
                              "deterministic"};
  for (size_t i = 0; i < std::size(keys); ++i) {
    TrainOptions options;
    const json before = to_json(options)[keys[i]];
    set_option_from_json(options, keys[i],
                         before.is_boolean() ? json(!before.get<bool>()) : json("pixel"));
    for (size_t j = 0; j < std::size(keys); ++j)
      EXPECT_EQ(bits(options)[j] != bits({})[j], i == j) << keys[i] << " at " << j;
  }
}

std::vector<std::string> all_keys() {
  std::vector<std::string> keys;
  for (const TrainOption& row : train_option_table()) keys.push_back(row.key);
  return keys;
}

INSTANTIATE_TEST_SUITE_P(Options, Switch, ::testing::ValuesIn(all_keys()),
                         [](const auto& row) { return row.param; });

}  // namespace
}  // namespace tessera::testing
