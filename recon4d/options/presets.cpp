// Presets as rows of data, the properties of a scene that they depend on, and their application. A
// preset only sets options that users can set as well.
#include "recon4d/options/presets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "kernels/base/camera_rig.h"
#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"

namespace tessera {
namespace {

/// No more than a scene needs: what moves and how many there are follows from the images.
const OptionOverrides kReduction = {
    {"size", "knee"}, {"decide_motion", true}, {"decide_colour", true}};
/// What is large stays: walls are.
const OptionOverrides kBalanced = joined(kReduction, {{"iterations", 7000},
                                                      {"init_points", 50000},
                                                      {"peak_gaussians", 400000},
                                                      {"prune_extent", 0},
                                                      {"sweep", true},
                                                      {"split_by_motion", true},
                                                      {"filter_2d", true},
                                                      {"average_from", 0.85}});
/// Gaussians grow where gradients stay large, up to a number that the pixels allow, and small
/// weights on opacities and scales keep the model from what only training views show
/// (research/growth.md).
const OptionOverrides kBudget = {{"densification", "budget"}, {"densify_threshold", 1e-4},
                                 {"prune_extent", 0},         {"gaussians_per_pixel", 1.8},
                                 {"opacity_weight", 0.003},   {"scale_weight", 0.003}};
const OptionOverrides kFast = joined(kBudget, {{"iterations", 2000},
                                               {"schedule_iterations", 30000},
                                               {"init_points", 20000},
                                               {"densify_interval", 50},
                                               {"peak_gaussians", 40000},
                                               {"thin_rounds", 3},
                                               {"sweep", true},
                                               {"split_by_motion", true},
                                               {"filter_2d", true}});
/// More steps and small weights against haze.
const OptionOverrides kBest =
    joined(kBalanced, {{"iterations", 15000}, {"opacity_weight", 0.003}, {"scale_weight", 0.003}});
/// Photos of a place, two a step: what is seen far behind it is part of it.
const OptionOverrides kStill = joined(kBudget, {{"far_plane", 1e4},
                                                {"decide_colour", false},
                                                {"batch", 2},
                                                {"idle_updates", "skip"},
                                                {"init_points", 30000},
                                                {"lr_mean", 2.3e-4},
                                                {"lr_mean_final", 2.3e-6},
                                                {"lr_scale", 7e-3},
                                                {"lr_rotation", 1.4e-3},
                                                {"lr_opacity", 0.035},
                                                {"lr_sh", 3.5e-3},
                                                {"lr_sh_rest", 7e-4},
                                                {"average_from", 0.85}});
const OptionOverrides kFastStill =
    joined(kStill, {{"iterations", 2800}, {"densify_interval", 25}, {"peak_gaussians", 150000}});
const OptionOverrides kBalancedStill =
    joined(kStill, {{"iterations", 6000}, {"densify_interval", 33}, {"peak_gaussians", 400000}});
const OptionOverrides kBestStill =
    joined(kStill, {{"iterations", 16000}, {"densify_interval", 50}, {"peak_gaussians", 800000}});
/// Several cameras that film at the same time: every timestep is seen from several sides, so
/// dynamic Gaussians start a few frames long, and cameras may differ in colour. Gaussians between
/// the cameras and the scene cover the views of others.
const OptionOverrides kAnyRig = {
    {"exposure", "auto"}, {"clocks", "auto"}, {"near_plane", 0}, {"moving_weight", 4}};
/// What stands still in a clip is drawn as its windows are.
const OptionOverrides kBackground = {
    {"far_plane", 100}, {"filter_2d", true}, {"near_plane", 0}, {"exposure", "auto"}};
/// What no training view shows would be grown at the cost of what moves.
const OptionOverrides kRig = joined(kAnyRig, {{"min_blending_weight", 0.05},
                                              {"spawn_missed", true},
                                              {"static_halves", true},
                                              {"noise", -1}});
constexpr FrameRates kRigRates = {.extent_frames = 3, .mean_time_rate = 0.02};
/// With few steps the velocities that the initial cloud has count for more than form.
const OptionOverrides kFastRig = joined(kAnyRig, {{"motion", "velocity"}});
constexpr FrameRates kFastRigRates = {
    .extent_frames = 3, .velocity_rate = 5.6e-5, .mean_time_rate = 0.05};
/// With one view a timestep, frames that a short trial holds out decide whether nodes carry
/// the scene (recon4d/training/motion_trial.h).
const OptionOverrides kSingleView = {{"motion", "auto"}};
const OptionOverrides kNodes = joined(
    kBudget, {{"min_blending_weight", 0.05}, {"densify_interval", 50}, {"peak_gaussians", 100000}});
const OptionOverrides kBestNodes = joined(kNodes, {{"iterations", 30000}});
/// Where nodes do not carry the scene, more views a step or steps gain nothing.
const OptionOverrides kBestSingleView = joined(
    joined(kSingleView, kBudget),
    {{"iterations", 14000}, {"batch", 2}, {"densify_interval", 50}, {"peak_gaussians", 200000}});
/// Times are stored in clip lengths, from the first frame to the last.
void apply_rates(TrainOptions& options, const FrameRates& rates, const SceneFacts& facts) {
  if (rates.extent_frames == 0) return;
  const double frames = double(facts.timesteps - 1);  // of a clip length
  options.init_time_scale = rates.extent_frames / frames;
  if (rates.velocity_rate > 0) options.lr_velocity = rates.velocity_rate * frames;
  options.lr_mean_time = rates.mean_time_rate / (frames * facts.extent);
}

/// What is seen from few sides is soon fitted beyond what it shows: fewer steps, and colours that
/// keep closer to one of all directions (research/growth.md). `count`: cameras of a rig, or images.
/// Returns its share of `many`, at most 1.
double fit_to_sides(TrainOptions& options, int64_t count, int64_t many, int64_t steps) {
  const double share = std::min(1.0, double(count) / double(many));
  options.iterations = std::min(options.iterations, steps * count);
  options.lr_sh_rest *= share;
  return share;
}

/// Fewer photos have fewer Gaussians, and more weight on small and faint ones.
void fit_to_photos(TrainOptions& options, int64_t views) {
  const double share = fit_to_sides(options, views, kManyViews, kStepsPerView);
  options.gaussians_per_pixel *= share;
  options.opacity_weight /= share;
  options.scale_weight /= share;
}

/// The more cameras film at once, the more of them see a Gaussian: it needs fewer pixels of each
/// and less weight against what only one of them shows (research/growth.md). In small images a
/// gradient by NDC stays large down to a fraction of a pixel, where static Gaussians fit noise.
void fit_to_cameras(TrainOptions& options, const SceneFacts& facts) {
  const int64_t cameras = std::max(facts.cameras, kFewCameras);
  if (facts.camera_pixels > 0)
    lower_limit(options, facts.camera_pixels * cameras / (kFewCameras * kPixelsOfFewCameras));
  if (!facts.rig()) return;
  fit_to_sides(options, facts.cameras, kManyCameras, kStepsPerCamera);
  if (facts.cameras < kEnoughCameras) options.clear_distance = -1;
  options.opacity_weight = options.scale_weight = kRigWeight / double(facts.cameras);
  if (facts.camera_pixels > 0 && facts.views > 0)
    options.static_threshold = std::max(
        1.0, std::sqrt(kThresholdPixels * double(facts.views) / double(facts.camera_pixels)));
}

}  // namespace

void lower_limit(TrainOptions& options, int64_t gaussians) {
  constexpr int64_t kLeast = 10000;
  const int64_t limit = std::max(kLeast, gaussians);
  if (options.peak_gaussians == 0 || options.peak_gaussians > limit) options.peak_gaussians = limit;
}

const std::vector<Preset>& presets() {
  static const std::vector<Preset> rows = {
      {"fast", "a first result: 2,000 steps, at most 40,000 Gaussians; photos 2,800 steps, 150,000",
       kFast, kFastStill, true, false, kFastRig, kFastRigRates},
      {"balanced",
       "the default: 7,000 steps, 6,000 of photos; what does not move becomes static, and the "
       "model is pruned",
       kBalanced, kBalancedStill, true, true, kRig, kRigRates, kSingleView, kNodes},
      {"best",
       "more of everything: 15,000 steps, 30,000 of one camera, 16,000 of photos and up to 800,000 "
       "Gaussians",
       kBest, kBestStill, true, true, kRig, kRigRates, kBestSingleView, kBestNodes},
      {"faster-gs",
       "the 4D protocol of Faster-GS: all dynamic, batch 4, opacity reset every 3000 steps",
       {{"opacity_reset_interval", 3000}, {"idle_updates", "skip"}}},
      {"yang4d",
       "Yang's N3DV protocol with plain SH: opacity reset every 3000 steps, no carving",
       {{"opacity_reset_interval", 3000}, {"carve", false}}},
      {"3dgs",
       "static 3DGS: one view a step, opacity reset",
       {{"motion", "none"},
        {"idle_updates", "skip"},
        {"batch", 1},
        {"lr_opacity", 0.025},
        {"opacity_reset_interval", 3000},
        {"far_plane", 1e4}}},
      {"mcmc",
       "static 3DGS with MCMC densification up to max_gaussians, no opacity reset",
       {{"motion", "none"},
        {"densification", "mcmc"},
        {"densify_until", 24900},
        {"opacity_weight", 0.01},
        {"scale_weight", 0.01},
        {"init_opacity", 0.5},
        {"batch", 1},
        {"far_plane", 1e4},
        {"lr_opacity", 0.05},
        {"max_gaussians", 1000000},
        {"init_scale_factor", 0.1}}},
  };
  return rows;
}

void apply_preset(TrainOptions& options, const std::string& name, const SceneFacts& facts) {
  apply_named(options, presets(), "preset", name, facts);
}

void apply_named(TrainOptions& options, const std::vector<NamedOptions>& table, const char* kind,
                 const std::string& name, const SceneFacts& facts) {
  std::vector<std::string> names;
  for (const NamedOptions& named : table) {
    names.push_back(named.name);
    if (name != named.name) continue;
    for (const auto& [key, value] : named.overrides) set_option(options, key, value);
    if (facts.still) {
      for (const auto& [key, value] : named.still_overrides) set_option(options, key, value);
      if (named.fits_to_views && facts.views > 0) fit_to_photos(options, facts.views);
    }
    if (facts.background && !named.rig_overrides.empty())
      for (const auto& [key, value] : kBackground) set_option(options, key, value);
    if (facts.rig()) {
      for (const auto& [key, value] : named.rig_overrides) set_option(options, key, value);
      apply_rates(options, named.rig_rates, facts);
    }
    if (facts.single_view)
      for (const auto& [key, value] : named.single_view_overrides) set_option(options, key, value);
    if (facts.nodes) {
      for (const auto& [key, value] : named.node_overrides) set_option(options, key, value);
      if (named.fits_to_views && facts.images > 0)
        fit_to_sides(options, facts.images, kManyViews, kStepsPerView);
    }
    if (named.fits_to_cameras) fit_to_cameras(options, facts);
    return;
  }
  throw InputError(fmt::format("unknown {} '{}'{}", kind, name, known_names(name, names)));
}

SceneFacts facts_of(const Scene& scene) {
  SceneFacts facts;
  facts.still = scene.is_static;
  facts.background = scene.static_of > 0;
  const CameraRig rig = make_camera_rig(scene.training_cameras());
  facts.extent = rig.extent;
  facts.views = int64_t(rig.cameras.size());
  for (const Camera& camera : rig.cameras)
    facts.camera_pixels += int64_t(camera.width) * camera.height;
  std::map<std::string, int64_t> frames;  // by camera
  const std::vector<int> training = scene.split_indices(Split::kTrain);
  for (const int i : training) ++frames[scene.frames[size_t(i)].camera_name];
  facts.images = int64_t(training.size());
  const int64_t timesteps = scene.timesteps_of(Split::kTrain);
  facts.single_view = timesteps > 1 && timesteps == int64_t(training.size());
  for (const auto& [camera, count] : frames) facts.timesteps = std::max(facts.timesteps, count);
  facts.cameras = std::count_if(frames.begin(), frames.end(), [&](const auto& camera) {
    return 2 * camera.second >= facts.timesteps;
  });
  return facts;
}

}  // namespace tessera
