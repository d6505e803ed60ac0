// Options of density control, the size of the model and the kernels.
#include "recon4d/options/option_rows.h"

namespace tessera {

void OptionRows::add_growth() {
  group("Density control");
  choice<&O::densification>(
      "densification", "[3DGS]; absolute gradient: [AbsGS]; mcmc: [3DGS-MCMC]",
      "adc: clone and split where gradients are large, prune faint Gaussians; budget: halve "
      "Gaussians that are drawn by their absolute gradients, in numbers that follow a curve up to "
      "peak_gaussians; mcmc: relocate faint Gaussians to opaque ones, up to max_gaussians");
  choice<&O::budget_without>("budget_without", "ours",
                             "A part that densification budget is to do without, as adc does");
  number("densify_from", &O::densify_from, kSteps, "[Faster-GS]", "First step of density control");
  number("densify_until", &O::densify_until, kSteps, "[Faster-GS]",
         "Last step of density control; 0: none");
  number("densify_interval", &O::densify_interval, kPositiveSteps, "[3DGS]",
         "Steps between two density controls; not scaled with the schedule");
  number("densify_threshold", &O::densify_threshold, {0, 1e12}, "[3DGS]",
         "Mean screen-space gradient (NDC) above which a Gaussian is cloned or split");
  number("static_threshold", &O::static_threshold, {0, 1e6}, "ours",
         "What densify_threshold is multiplied by for the static set");
  on_off("static_halves", &O::static_halves, "ours",
         "Static Gaussians that grow are halved along their longest axis and drawn by their "
         "gradients, as by densification budget; of the lengths of the gradients of their pixels "
         "1/(8 + 8 noise) counts where it is more than the gradient");
  number("dense_fraction", &O::dense_fraction, {0, 1e6}, "[3DGS]",
         "Largest scale of a clone, per scene extent; larger Gaussians are split");
  number("prune_opacity", &O::prune_opacity, kShare, "[3DGS]",
         "Opacity below which Gaussians are removed (adc) or relocated (mcmc)");
  number("prune_extent", &O::prune_extent, {0, 1e6}, "[3DGS]",
         "Scale, per scene extent, above which Gaussians are removed; 0: never");
  number("prune_large_from", &O::prune_large_from, kSteps, "[3DGS]",
         "First step at which prune_extent applies");
  number("opacity_reset_interval", &O::opacity_reset_interval, kSteps, "[Hybrid4D]",
         "Steps between two opacity resets, with one more at 500 unless the background is black; "
         "0: never");
  number("mcmc_noise", &O::mcmc_noise, {0, 1e12}, "[3DGS-MCMC]",
         "Noise on means, by covariance and learning rate of the mean");
  number("mcmc_growth", &O::mcmc_growth, {1, 1e6}, "[3DGS-MCMC]",
         "Factor by which a density control may grow the number of Gaussians");
  number("min_blending_weight", &O::min_blending_weight, kShare, "ours",
         "Remove Gaussians whose largest blending weight over all pixels of the training views is "
         "less; 0: keep them");
  number("unseen_interval", &O::unseen_interval, kPositiveSteps, "ours",
         "Steps between two removals of Gaussians with too small a blending weight");
  number(
      "clear_distance", &O::clear_distance, {-1, 1e9, Unit::kWorld}, "ours",
      "Remove Gaussians in the view of a training camera that are nearer to it; 0: keep them; -1: "
      "four fifths of the depth at which the cameras see the first points of the initial cloud");
  number("reorder_interval", &O::reorder_interval, kSteps, "[Faster-GS]",
         "Steps between two Morton reorderings while density control is on; 0: never");

  group("Model size");
  number("max_gaussians", &O::max_gaussians, kGaussians, "ours",
         "Largest number of Gaussians of the finished model; 0: no limit")
      .example("50k");
  number("max_bytes", &O::max_bytes, {0, 1e14, Unit::kBytes}, "ours",
         "Largest size of the exported file (export --format tessera); a player page adds about 3 "
         "MB; 0: no limit")
      .example("5MB");
  number("within_db", &O::within_db, {0, 100}, "ours",
         "Keep the smallest model whose validation PSNR is within so many dB of the best; 0: off")
      .example("0.3");
  choice<&O::size>(
      "size", "ours",
      "Without one of these three limits: grown (as density control leaves it) or knee (where the "
      "curve of size and error bends)");
  number("peak_gaussians", &O::peak_gaussians, kGaussians, "ours",
         "Largest number of Gaussians during growth, before pruning; 0: max_gaussians limits "
         "growth");
  number("gaussians_per_pixel", &O::gaussians_per_pixel, {0, 1e3}, "ours",
         "Lowers peak_gaussians to that many for each pixel that a training image shows on "
         "average, without ignored pixels and empty background; 0: it stays as it is");
  number("thin_rounds", &O::thin_rounds, {1, 1000}, "ours",
         "Pruning rounds after growth, with recovery between them");
  number("thin_until", &O::thin_until, kSteps, "ours", "Last step of the pruning rounds");
  on_off("decide_motion", &O::decide_motion, "ours",
         "Demote dynamic Gaussians to static where motion reduces the error too little, and "
         "promote static ones where the error changes over time");
  on_off("spawn_missed", &O::spawn_missed, "ours",
         "At the first decision about motion, add dynamic Gaussians where several cameras of a rig "
         "miss what moves");
  on_off("decide_colour", &O::decide_colour, "ours",
         "After growth, keep for each Gaussian the SH degree that justifies its bytes");
  number("decide_interval", &O::decide_interval, kPositiveSteps, "ours",
         "Steps between two decisions about motion during growth");

  group("Kernels");
  on_off("deterministic", &O::deterministic, "ours",
         "Bit-identical models on the same device: sum gradients in a fixed order (CUDA, about a "
         "fifth slower; the CPU always does)");
  number("feed_bytes", &O::feed_bytes, {0, 1e12, Unit::kBytes}, "ours",
         "CUDA: memory for training images; what does not fit is copied ahead of each step; 0: the "
         "free memory but for a reserve");
  on_off("rectangular_bounds", &O::rectangular_bounds, "[Faster-GS]",
         "Bound splats by rectangles, not squares");
  on_off("opacity_bounds", &O::opacity_bounds, "[Faster-GS]", "Shrink the bounds of faint splats");
  on_off("balanced_instances", &O::balanced_instances, "[Faster-GS]",
         "CUDA: whole warps write the tile instances of large splats");
  on_off("separate_sort", &O::separate_sort, "[Splatshop]",
         "CUDA: sort by depth once, then by tile, not by both together");
  on_off("warp_culling", &O::warp_culling, "ours",
         "CUDA: a warp skips splats that miss its part of the tile");
  choice<&O::backward>("backward", "[Faster-GS]; sub-tile: ours",
                       "CUDA: traversal of the gradient of blending: sub-tile or pixel");
}

}  // namespace tessera
