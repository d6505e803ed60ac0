// What: the option table: name, member, range, meaning and source of every knob.
// Not: setting them (train_options.cpp), nor any use of the values.
#include "recon4d/train_options.h"

namespace tessera {
namespace {

using O = TrainOptions;
constexpr double kMany = 1e12;

}  // namespace

const std::vector<OptionRow>& train_option_rows() {
  static const std::vector<OptionRow> rows = {
      {"iterations", &O::iterations, 0, 1e9, "training steps; each takes a batch of views",
       "[3DGS]"},
      {"schedule_iterations", &O::schedule_iterations, 1, 1e9,
       "length that the step counts below refer to; they are scaled by iterations / this", "ours"},
      {"batch", &O::batch, 1, 1024, "(view, time) pairs per step", "[Yang24]"},
      {"seed", &O::seed, 0, kMany, "of every random choice", "ours"},
      {"static_only", &O::static_only, 0, 1, "one static set, no dynamic Gaussians", "[3DGS]"},
      {"background", &O::background, 0, 0, "colour behind the scene: black, white or r,g,b (0-255)",
       "[Faster-GS]"},
      {"near_plane", &O::near_plane, 1e-6, 1e9, "world units; nearer Gaussians are not drawn",
       "[3DGS]"},
      {"far_plane", &O::far_plane, 1e-6, 1e12, "world units; farther Gaussians are not drawn",
       "[Faster-GS]"},
      {"init_points", &O::init_points, 0, 1e9,
       "random initial Gaussians where there is no point cloud; largest share taken of a cloud",
       "[Yang24]"},
      {"init_extent", &O::init_extent, 0, 1e9,
       "half size of the box of random points, world units; 0: from the cameras", "[Faster-GS]"},
      {"init_opacity", &O::init_opacity, 1e-6, 0.999999, "initial opacity", "[3DGS]"},
      {"init_time_scale", &O::init_time_scale, 1e-6, 1e6, "initial temporal sigma, in clip lengths",
       "[Yang24]"},
      {"static_fraction", &O::static_fraction, 0, 1,
       "share of the initial Gaussians that start in the static set", "ours"},
      {"carve", &O::carve, 0, 1, "drop random points that no training camera sees", "[Faster-GS]"},
      {"sweep", &O::sweep, 0, 1,
       "without a point cloud: find initial points by a plane sweep where cameras share moments",
       "[Collins96]"},
      {"split_by_motion", &O::split_by_motion, 0, 1,
       "swept points whose pixel never changes start in the static set", "ours"},
      {"sh_degree", &O::sh_degree, 0, 3, "highest spherical-harmonics degree", "[3DGS]"},
      {"sh_interval", &O::sh_interval, 1, 1e9, "steps between two degrees", "[3DGS]"},
      {"sliced_direction", &O::sliced_direction, 0, 1,
       "colours depend on the direction to a Gaussian where it is at the view's moment; false: to "
       "its "
       "mean over time",
       "ours; [Yang24] and [Faster-GS] have false"},
      {"lambda_dssim", &O::lambda_dssim, 0, 1, "weight of 1 - SSIM; the rest is L1", "[3DGS]"},
      {"lr_mean", &O::lr_mean, 0, 1e3, "of means at the start, per scene extent", "[3DGS]"},
      {"lr_mean_final", &O::lr_mean_final, 0, 1e3, "of means at the end, per scene extent",
       "[3DGS]"},
      {"lr_mean_time", &O::lr_mean_time, 0, 1e3, "of temporal means, per scene extent", "[Yang24]"},
      {"lr_scale", &O::lr_scale, 0, 1e3, "of log scales", "[3DGS]"},
      {"lr_scale_time", &O::lr_scale_time, 0, 1e3, "of the temporal log scale", "[Yang24]"},
      {"lr_rotation", &O::lr_rotation, 0, 1e3, "of quaternions", "[3DGS]"},
      {"lr_opacity", &O::lr_opacity, 0, 1e3, "of opacity logits", "[Yang24]; [3DGS] has 0.025"},
      {"lr_sh", &O::lr_sh, 0, 1e3, "of the first SH coefficient", "[3DGS]"},
      {"lr_sh_rest", &O::lr_sh_rest, 0, 1e3, "of the other SH coefficients", "[3DGS]"},
      {"fused_optimizer", &O::fused_optimizer, 0, 1,
       "Adam inside the backward pass, without a gradient buffer", "[Faster-GS]"},
      {"idle_updates",
       &O::idle_updates,
       0,
       0,
       "Adam for Gaussians out of sight: dense: as for any other; lazy: the same, but colours "
       "catch "
       "up when they are seen; skip: none",
       "ours; skip: [Taming]",
       {"dense", "lazy", "skip"}},
      {"densify_from", &O::densify_from, 0, 1e9, "first step of density control", "[Faster-GS]"},
      {"densify_until", &O::densify_until, 0, 1e9, "last step of density control; 0: none",
       "[Faster-GS]"},
      {"densify_interval", &O::densify_interval, 1, 1e9,
       "steps between two density controls; not scaled", "[3DGS]"},
      {"densify_threshold", &O::densify_threshold, 0, kMany,
       "mean screen-space gradient (NDC) above which a Gaussian is cloned or split", "[3DGS]"},
      {"dense_fraction", &O::dense_fraction, 0, 1e6,
       "largest scale of a clone, per scene extent; larger ones are split", "[3DGS]"},
      {"prune_opacity", &O::prune_opacity, 0, 1, "Gaussians below are removed", "[3DGS]"},
      {"prune_extent", &O::prune_extent, 0, 1e6,
       "Gaussians with a larger scale, per scene extent, are removed", "[3DGS]"},
      {"prune_large_from", &O::prune_large_from, 0, 1e9, "first step at which prune_extent holds",
       "[3DGS]"},
      {"opacity_reset_interval", &O::opacity_reset_interval, 0, 1e9,
       "steps between two opacity resets, with one more at 500 unless the background is black; 0: "
       "never, the default in 4D",
       "[Hybrid4D]"},
      {"max_gaussians", &O::max_gaussians, 0, 1e9, "upper limit of both sets together; 0: none",
       "ours"},
      {"reorder_interval", &O::reorder_interval, 0, 1e9,
       "steps between two Morton re-orderings, until density control has ended; 0: never",
       "[Faster-GS]"},
      {"rectangular_bounds", &O::rectangular_bounds, 0, 1,
       "boxes of splats as wide and high as they are, not squares", "[Faster-GS]"},
      {"opacity_bounds", &O::opacity_bounds, 0, 1, "boxes of faint splats are smaller",
       "[Faster-GS]"},
      {"tile_culling", &O::tile_culling, 0, 1, "each tile of the box is tested, else all are taken",
       "[StopThePop]"},
      {"row_intervals", &O::row_intervals, 0, 1,
       "tile culling by one interval for each row of tiles", "ours"},
      {"balanced_instances", &O::balanced_instances, 0, 1,
       "device: large splats are written by whole warps", "[Faster-GS]"},
      {"separate_sort", &O::separate_sort, 0, 1,
       "device: depth is sorted once, then tiles, not both at once", "[Splatshop]"},
      {"warp_culling", &O::warp_culling, 0, 1,
       "device: a warp skips splats that miss its part of the tile", "ours"},
      {"backward",
       &O::backward,
       0,
       0,
       "device: how the gradient of blending is traversed",
       "[Faster-GS]; sub-tile: ours",
       {"sub-tile", "pixel", "per-gaussian"}},
      {"deterministic", &O::deterministic, 0, 1,
       "device: gradients are added in a fixed order; the CPU always does", "ours"},
      {"feed_bytes", &O::feed_bytes, 0, kMany,
       "device: bytes for training frames, fewer are brought over ahead of each step; 0: what is "
       "free but for a reserve",
       "ours"},
  };
  return rows;
}

}  // namespace tessera
