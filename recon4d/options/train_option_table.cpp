// What: the option table: name, member, range, meaning and source of every knob.
// Not: setting them (train_options.cpp), nor any use of the values.
#include <type_traits>
#include <utility>

#include "kernels/math/spherindrical.h"
#include "recon4d/options/train_options.h"

namespace tessera {
namespace {

using O = TrainOptions;
constexpr double kMany = 1e12;

template <auto Member>
ChoiceMember choice() {
  using Enum = std::remove_reference_t<decltype(std::declval<O&>().*Member)>;
  return {choice_names<Enum>(), [](const O& options) { return size_t(options.*Member); },
          [](O& options, size_t value) { options.*Member = Enum(value); }};
}

}  // namespace

const std::vector<TrainOption>& train_option_table() {
  static const std::vector<TrainOption> table = {
      {"iterations", &O::iterations, 0, 1e9, "training steps; each takes a batch of views",
       "[3DGS]"},
      {"schedule_iterations", &O::schedule_iterations, 1, 1e9,
       "length that the step counts below refer to; they are scaled by iterations / this", "ours"},
      {"batch", &O::batch, 1, 1024, "(view, time) pairs per step", "[Yang24]"},
      {"seed", &O::seed, 0, kMany, "of every random choice", "ours"},
      {"static_only", &O::static_only, 0, 1, "one static set, no dynamic Gaussians", "[3DGS]"},
      {"motion_form", choice<&O::motion_form>(), 0, 0,
       "how dynamic Gaussians are stored: pair (two quaternions and four scales of space-time) or "
       "velocity (a static Gaussian with a velocity and a temporal scale)",
       "[Yang24]; velocity: [FreeTimeGS]"},
      {"background", &O::background, 0, 0, "colour behind the scene: black, white or r,g,b (0-255)",
       "[Faster-GS]"},
      {"near_plane", &O::near_plane, 1e-6, 1e9, "world units; nearer Gaussians are not drawn",
       "[3DGS]"},
      {"far_plane", &O::far_plane, 1e-6, 1e12, "world units; farther Gaussians are not drawn",
       "[Faster-GS]"},
      {"train_scale", &O::train_scale, 1e-3, 1,
       "size of the images that are trained on, by the scene's: averaged over areas",
       "[Mip-Splatting]"},
      {"init_points", &O::init_points, 0, 1e9,
       "random initial Gaussians where there is no point cloud; largest share taken of a cloud",
       "[Yang24]"},
      {"init_extent", &O::init_extent, 0, 1e9,
       "half size of the box of random points, world units; 0: from the cameras", "[Faster-GS]"},
      {"init_opacity", &O::init_opacity, 1e-6, 0.999999, "initial opacity", "[3DGS]"},
      {"init_scale_factor", &O::init_scale_factor, 1e-6, 1e6,
       "initial scales, by the distance of a point to its neighbours", "[3DGS]"},
      {"init_time_scale", &O::init_time_scale, 1e-6, 1e6, "initial temporal sigma, in clip lengths",
       "[Yang24]"},
      {"static_fraction", &O::static_fraction, 0, 1,
       "least share of the initial Gaussians of which no motion is known that start static",
       "ours"},
      {"carve", &O::carve, 0, 1, "drop random points that no training camera sees", "[Faster-GS]"},
      {"sweep", &O::sweep, 0, 1,
       "without a point cloud: find initial points by a plane sweep where cameras share moments",
       "[Collins96]"},
      {"split_by_motion", &O::split_by_motion, 0, 1,
       "points whose pixel never changes start in the static set, and as many of the random ones",
       "ours"},
      {"validation_share", &O::validation_share, 0, 0.9,
       "share of the training frames used as validation frames to choose the best model; 0: none, "
       "the last "
       "model is kept",
       "ours"},
      {"validate_interval", &O::validate_interval, 1, 1e9,
       "steps between two checks of the validation frames", "ours"},
      {"stop_patience", &O::stop_patience, 0, 1e9,
       "checks in a row without a gain of 0.02 dB that end the training; 0: none do", "ours"},
      {"sh_degree", &O::sh_degree, 0, 3, "highest spherical-harmonics degree", "[3DGS]"},
      {"sh_interval", &O::sh_interval, 1, 1e9, "steps between two degrees", "[3DGS]"},
      {"sh_time_degree", &O::sh_time_degree, 0, kMaxTimeLevels,
       "highest n of cos(2 pi n t / clip length) by which colours of dynamic Gaussians change; 0: "
       "they do not. One more every sh_interval after the last degree",
       "[Yang24], which has 2"},
      {"sliced_direction", &O::sliced_direction, 0, 1,
       "colours depend on the direction to a Gaussian where it is at the view's moment; false: to "
       "its mean over time",
       "ours; [Yang24] and [Faster-GS] have false"},
      {"filter_2d", &O::filter_2d, 0, 1,
       "splats are widened by 0.1 px^2 and dimmed to keep their light; false: by 0.3, not dimmed",
       "[Mip-Splatting]"},
      {"filter_3d", choice<&O::filter_3d>(), 0, 0,
       "no Gaussian finer than the nearest training view samples: none; mip: smoothed and dimmed "
       "when drawn, baked at the end; clamp: scales are raised after each step",
       "mip: [Mip-Splatting]; clamp: [Faster-GS]"},
      {"truncation_sigma", &O::truncation_sigma, 0.5, 6,
       "k: opacity times falloff below exp(-k^2/2) is not drawn; 3.3290: 1/255", "[3DGS]"},
      {"truncation_by_falloff", &O::truncation_by_falloff, 0, 1,
       "falloff alone below exp(-k^2/2) is not drawn, whatever the opacity", "[Faster-GS]"},
      {"time_filter", &O::time_filter, 0, 1e6,
       "clip lengths^2, added to the variance in time by which dynamic Gaussians fade", "[Yang24]"},
      {"lambda_dssim", &O::lambda_dssim, 0, 1, "weight of 1 - SSIM; the rest is L1", "[3DGS]"},
      {"opacity_weight", &O::opacity_weight, 0, 1e6, "weight of the mean opacity in the loss",
       "[3DGS-MCMC], which has 0.01"},
      {"scale_weight", &O::scale_weight, 0, 1e6,
       "weight of the mean scale in space in the loss, per world unit",
       "[3DGS-MCMC], which has 0.01"},
      {"environment", &O::environment, 0, 1,
       "a map of light from beyond the scene, learnt behind the Gaussians; for captures without an "
       "alpha channel",
       "[Yang24]"},
      {"environment_size", &O::environment_size, 2, 4096,
       "rows of the environment's map, which has twice as many columns", "ours"},
      {"lr_environment", &O::lr_environment, 0, 1e3, "of the environment's map", "[Yang24]"},
      {"exposure", choice<&O::exposure>(), 0, 0,
       "RGB gains learnt for the training images: none, one for each camera, or one for each "
       "frame of each camera; their mean is 1, and nothing else is drawn with them",
       "ours"},
      {"lr_exposure", &O::lr_exposure, 0, 1e3,
       "of log gains at the start; falls to a hundredth over the training", "ours"},
      {"lr_mean", &O::lr_mean, 0, 1e3, "of means at the start, per scene extent", "[3DGS]"},
      {"lr_mean_final", &O::lr_mean_final, 0, 1e3, "of means at the end, per scene extent",
       "[3DGS]"},
      {"lr_mean_time", &O::lr_mean_time, 0, 1e3, "of temporal means at the start, per scene extent",
       "[Yang24]"},
      {"lr_scale", &O::lr_scale, 0, 1e3, "of log scales", "[3DGS]"},
      {"lr_scale_time", &O::lr_scale_time, 0, 1e3, "of the temporal log scale", "[Yang24]"},
      {"lr_rotation", &O::lr_rotation, 0, 1e3, "of quaternions", "[3DGS]"},
      {"lr_velocity", &O::lr_velocity, 0, 1e3,
       "of velocities at the start, per scene extent and clip length; decays as lr_mean does",
       "ours"},
      {"lr_opacity", &O::lr_opacity, 0, 1e3, "of opacity logits", "[Yang24]; [3DGS] has 0.025"},
      {"lr_sh", &O::lr_sh, 0, 1e3, "of the first SH coefficient", "[3DGS]"},
      {"lr_sh_rest", &O::lr_sh_rest, 0, 1e3, "of the other SH coefficients", "[3DGS]"},
      {"fused_optimizer", &O::fused_optimizer, 0, 1,
       "Adam inside the backward pass, without a gradient buffer", "[Faster-GS]"},
      {"idle_updates", choice<&O::idle_updates>(), 0, 0,
       "Adam for Gaussians that no view of a step sees: dense: as for any other; skip: none",
       "skip: [Taming]"},
      {"densification", choice<&O::densification>(), 0, 0,
       "adc: strong gradients are cloned and split, the faint removed; mcmc: the faint are moved "
       "to "
       "the opaque, up to exactly max_gaussians, and means take random steps",
       "[3DGS]; mcmc: [3DGS-MCMC]"},
      {"densify_from", &O::densify_from, 0, 1e9, "first step of density control", "[Faster-GS]"},
      {"densify_until", &O::densify_until, 0, 1e9, "last step of density control; 0: none",
       "[Faster-GS]"},
      {"densify_interval", &O::densify_interval, 1, 1e9,
       "steps between two density controls; not scaled", "[3DGS]"},
      {"densify_threshold", &O::densify_threshold, 0, kMany,
       "mean screen-space gradient (NDC) above which a Gaussian is cloned or split", "[3DGS]"},
      {"dense_fraction", &O::dense_fraction, 0, 1e6,
       "largest scale of a clone, per scene extent; larger ones are split", "[3DGS]"},
      {"prune_opacity", &O::prune_opacity, 0, 1, "Gaussians below are removed, by mcmc moved",
       "[3DGS]"},
      {"prune_extent", &O::prune_extent, 0, 1e6,
       "Gaussians with a larger scale, per scene extent, are removed; 0: none", "[3DGS]"},
      {"prune_large_from", &O::prune_large_from, 0, 1e9, "first step at which prune_extent holds",
       "[3DGS]"},
      {"opacity_reset_interval", &O::opacity_reset_interval, 0, 1e9,
       "steps between two opacity resets, with one more at 500 unless the background is black; 0: "
       "never, the default in 4D",
       "[Hybrid4D]"},
      {"max_gaussians", &O::max_gaussians, 0, 1e9,
       "Gaussians of both sets together that are shipped; 0: no limit", "ours"},
      {"max_bytes", &O::max_bytes, 0, 1e14,
       "bytes of the shipped file (export --format tessera); 0: no limit", "ours"},
      {"within_db", &O::within_db, 0, 100,
       "ship the smallest model whose PSNR on the validation frames is within so many dB of the "
       "best; 0: no such",
       "ours"},
      {"size", choice<&O::size>(), 0, 0,
       "without one of these three: grown: as density control leaves it; knee: where the scene's "
       "own curve of size and error bends",
       "ours"},
      {"peak_gaussians", &O::peak_gaussians, 0, 1e9,
       "most Gaussians while they grow, before they are pruned; 0: max_gaussians limits "
       "growth itself",
       "ours"},
      {"thin_rounds", &O::thin_rounds, 1, 1000,
       "rounds in which Gaussians are pruned, after growth, with recovery between them", "ours"},
      {"thin_until", &O::thin_until, 0, 1e9, "last step at which they are", "ours"},
      {"decide_motion", &O::decide_motion, 0, 1,
       "dynamic Gaussians whose motion contributes too little become static, and where what is "
       "left "
       "over static ones changes with time dynamic ones are born",
       "ours"},
      {"decide_colour", &O::decide_colour, 0, 1,
       "after growth each Gaussian keeps the SH degree that justifies its bytes", "ours"},
      {"decide_interval", &O::decide_interval, 1, 1e9,
       "steps between two decisions about motion until growth has ended", "ours"},
      {"mcmc_noise", &O::mcmc_noise, 0, kMany,
       "random steps of means, by covariance and learning rate of the mean", "[3DGS-MCMC]"},
      {"mcmc_growth", &O::mcmc_growth, 1, 1e6,
       "Gaussians after a density control by those before, until max_gaussians", "[3DGS-MCMC]"},
      {"reorder_interval", &O::reorder_interval, 0, 1e9,
       "steps between two Morton re-orderings, until density control has ended; 0: never",
       "[Faster-GS]"},
      {"rectangular_bounds", &O::rectangular_bounds, 0, 1,
       "boxes of splats as wide and high as they are, not squares", "[Faster-GS]"},
      {"opacity_bounds", &O::opacity_bounds, 0, 1, "boxes of faint splats are smaller",
       "[Faster-GS]"},
      {"balanced_instances", &O::balanced_instances, 0, 1,
       "device: large splats are written by whole warps", "[Faster-GS]"},
      {"separate_sort", &O::separate_sort, 0, 1,
       "device: depth is sorted once, then tiles, not both at once", "[Splatshop]"},
      {"warp_culling", &O::warp_culling, 0, 1,
       "device: a warp skips splats that miss its part of the tile", "ours"},
      {"backward", choice<&O::backward>(), 0, 0,
       "device: how the gradient of blending is traversed", "[Faster-GS]; sub-tile: ours"},
      {"deterministic", &O::deterministic, 0, 1,
       "device: gradients are added in a fixed order; the CPU always does", "ours"},
      {"feed_bytes", &O::feed_bytes, 0, kMany,
       "device: bytes for training frames, fewer are brought over ahead of each step; 0: what is "
       "free but for a reserve",
       "ours"},
  };
  return table;
}

}  // namespace tessera
