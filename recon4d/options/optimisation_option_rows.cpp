// Options of the loss and of learning rates.
#include "recon4d/options/option_rows.h"

namespace tessera {

void OptionRows::add_optimisation() {
  group("Loss and exposure");
  number("lambda_dssim", &O::lambda_dssim, kShare, "[3DGS]",
         "Weight of 1 - SSIM in the loss; the rest is L1");
  number(
      "noise", &O::noise, {-1, 255}, "ours",
      "Standard deviation of the noise of the images, of 255 levels, that SSIM in the loss allows "
      "for; -1: measured in their flattest parts");
  number("moving_weight", &O::moving_weight, {0, 1e3}, "ours",
         "Weight that is added to the L1 of pixels that differ by more than 10 of 255 from the "
         "median over time of their camera, where that stands still");
  number("opacity_weight", &O::opacity_weight, kWeight, "[3DGS-MCMC], which has 0.01",
         "Weight of the mean opacity in the loss");
  number("scale_weight", &O::scale_weight, kWeight, "[3DGS-MCMC], which has 0.01",
         "Weight of the mean spatial scale in the loss, per world unit");
  choice<&O::exposure>(
      "exposure", "ours",
      "Learn colours of the training images: none; camera (an RGB gain each); affine (a 3x3 matrix "
      "and an offset each); frame (a gain per image); auto (camera where gains differ by more than "
      "3 %, else none). Scores and exports use the mean camera");

  choice<&O::clocks>(
      "clocks", "ours",
      "Clocks of the training cameras: fixed (as the scene states them), learn (an offset each, up "
      "to a frame) or auto (learn where motion or sound moved one). Scores and exports use the "
      "mean clock");
  on_off("learn_readouts", &O::learn_readouts, "ours",
         "Learn the readout of each training camera's rolling shutter, up to a frame from what the "
         "scene states. Exports show one instant");

  group("Optimiser");
  number("lr_exposure", &O::lr_exposure, kRate, "ours",
         "Learning rate of log exposure gains at the start, ten times that of affine maps; falls "
         "to a hundredth");
  number("lr_clocks", &O::lr_clocks, kRate, "ours",
         "Learning rate of clocks and readouts at the start, in frames; falls to a hundredth");
  number("lr_environment", &O::lr_environment, kRate, "[Yang24]",
         "Learning rate of the environment map");
  number("lr_mean", &O::lr_mean, kRate, "[3DGS]",
         "Learning rate of means at the start, per scene extent");
  number("lr_mean_final", &O::lr_mean_final, kRate, "[3DGS]",
         "Learning rate of means at the end, per scene extent");
  number("lr_mean_time", &O::lr_mean_time, kRate, "[Yang24]",
         "Learning rate of temporal means at the start, per scene extent");
  number("lr_scale", &O::lr_scale, kRate, "[3DGS]", "Learning rate of log scales");
  number("lr_scale_time", &O::lr_scale_time, kRate, "[Yang24]",
         "Learning rate of log temporal extents");
  number("lr_rotation", &O::lr_rotation, kRate, "[3DGS]", "Learning rate of quaternions");
  number("lr_velocity", &O::lr_velocity, kRate, "ours",
         "Learning rate of velocities at the start, per scene extent and clip length; decays as "
         "lr_mean does");
  number("lr_opacity", &O::lr_opacity, kRate, "[Yang24]; [3DGS] has 0.025",
         "Learning rate of opacity logits");
  number("lr_sh", &O::lr_sh, kRate, "[3DGS]", "Learning rate of the first SH coefficient");
  number("lr_sh_rest", &O::lr_sh_rest, kRate, "[3DGS]",
         "Learning rate of the other SH coefficients");
  number("average_from", &O::average_from, kShare, "[Polyak92]",
         "Share of the steps after which the parameters are averaged; the mean becomes the model; "
         "0: the last step is the model");
  on_off("fused_optimizer", &O::fused_optimizer, "[Faster-GS]",
         "Run Adam inside the backward pass, without a gradient buffer");
  choice<&O::idle_updates>(
      "idle_updates", "skip: [Taming]",
      "Adam for Gaussians that no view of a step sees: dense (as for all others) or skip");
}

}  // namespace tessera
