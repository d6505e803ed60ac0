// Options of the length of a training, the scene, the initial Gaussians, and what a Gaussian is and
// how it is drawn.
#include "kernels/math/spherindrical.h"
#include "recon4d/options/option_rows.h"

namespace tessera {

void OptionRows::add_model() {
  group("Length");
  number("iterations", &O::iterations, kSteps, "[3DGS]",
         "Training steps; each uses one batch of views. Stretches the whole schedule")
      .example("15k");
  number("schedule_iterations", &O::schedule_iterations, kPositiveSteps, "ours",
         "Length that other step counts refer to; they are scaled by iterations / this");
  number("batch", &O::batch, {1, 1024, Unit::kCount}, "[Yang24]",
         "Views (camera and time) per step")
      .example("8");
  number("seed", &O::seed, {0, 1e12}, "ours", "Seed of every random choice").example("2");

  group("Scene");
  choice<&O::motion>(
      "motion", "[Yang24]; velocity: [FreeTimeGS]; nodes: ours, after [SC-GS]",
      "How the scene moves: none (static Gaussians only, as 3DGS; all images count as one "
      "timestep), pair (two quaternions and four scales of space-time), velocity (a 3D Gaussian "
      "with a velocity and a temporal extent), nodes (one set of Gaussians that motion nodes "
      "carry), auto (nodes or pair, by frames held out of a short trial)");
  text("background", &O::background, "[Faster-GS]",
       "Colour behind the scene: black, white or r,g,b (0-255)")
      .example("255,255,255");
  number("near_plane", &O::near_plane, kDistance, "[3DGS]",
         "Nearest depth at which Gaussians are drawn; 0: half of the depth at which the training "
         "cameras see the first points of the initial cloud");
  number("far_plane", &O::far_plane, {1e-6, 1e12, Unit::kWorld}, "[Faster-GS]",
         "Farthest depth at which Gaussians are drawn");
  number("train_scale", &O::train_scale, {1e-3, 1}, "[Mip-Splatting]",
         "Size of the training images relative to the scene's; areas are averaged")
      .example("0.5");

  group("Initial Gaussians");
  number("init_points", &O::init_points, kGaussians, "[Yang24]",
         "Initial Gaussians: at most so many points of the cloud, or so many random points")
      .example("100k");
  number("init_extent", &O::init_extent, kDistance, "[Faster-GS]",
         "Half the side of the box of random points; 0: from the cameras");
  number("init_opacity", &O::init_opacity, {1e-6, 0.999999}, "[3DGS]", "Initial opacity");
  number("init_scale_factor", &O::init_scale_factor, {1e-6, 1e6}, "[3DGS]",
         "Initial scale relative to the distance of a point to its neighbours");
  number("init_time_scale", &O::init_time_scale, {1e-6, 1e6}, "[Yang24]",
         "Initial temporal extent (standard deviation) in clip lengths");
  number("static_fraction", &O::static_fraction, kShare, "ours",
         "Least share of the initial Gaussians of unknown motion that start static");
  on_off("carve", &O::carve, "[Faster-GS]", "Drop random points that no training camera sees");
  on_off("sweep", &O::sweep, "[Collins96]",
         "Without a point cloud, find points by a plane sweep where cameras share timesteps");
  on_off("split_by_motion", &O::split_by_motion, "ours",
         "Points whose pixel never changes start static, and as large a share of random ones");

  group("Validation views");
  number("validation_share", &O::validation_share, {0, 0.9}, "ours",
         "Share of the training views kept as validation views that choose the best model; 0: the "
         "last model is kept")
      .example("0.1");
  number("validate_interval", &O::validate_interval, kPositiveSteps, "ours",
         "Steps between two scores of the validation views");
  number("stop_patience", &O::stop_patience, {0, 1e9}, "ours",
         "Scores in a row without a gain of 0.02 dB after which training stops; 0: never");

  group("Model");
  number("sh_degree", &O::sh_degree, {0, 3}, "[3DGS]",
         "Highest degree of the spherical harmonics (SH) of the colours")
      .example("2");
  number("sh_interval", &O::sh_interval, kPositiveSteps, "[3DGS]",
         "Steps after which one more SH degree is used");
  number("sh_time_degree", &O::sh_time_degree, {0, kMaxTimeLevels}, "[Yang24], which has 2",
         "Highest n of cos(2 pi n t / clip length) in the colours of dynamic Gaussians; 0: colours "
         "do not change over time. One more is used every sh_interval steps");
  on_off("environment", &O::environment, "[Yang24]",
         "Learn an environment map behind the Gaussians; needs images without alpha");
  number("environment_size", &O::environment_size, {2, 4096}, "ours",
         "Rows of the environment map; it has twice as many columns");

  group("Rendering");
  on_off("sliced_direction", &O::sliced_direction, "ours; [Yang24] and [Faster-GS] have false",
         "Evaluate colours by the direction to the Gaussian at the view's time; no: to its "
         "temporal mean position");
  on_off("filter_2d", &O::filter_2d, "[Mip-Splatting]",
         "2D Mip filter: widen splats by 0.1 px^2 and compensate the opacity; no: by 0.3 px^2 "
         "without compensation");
  choice<&O::filter_3d>(
      "filter_3d", "mip: [Mip-Splatting]; clamp: [Faster-GS]",
      "Limit Gaussians to the finest sampling of the training views: none; mip (smooth when "
      "drawn); clamp (raise scales after each step)");
  number("truncation_sigma", &O::truncation_sigma, {0.5, 6}, "[3DGS]",
         "k: opacity times falloff below exp(-k^2/2) is not drawn; 3.329 means 1/255");
  on_off("truncation_by_falloff", &O::truncation_by_falloff, "[Faster-GS]",
         "Compare the falloff alone with exp(-k^2/2), whatever the opacity");
  number("time_filter", &O::time_filter, {0, 1e6}, "[Yang24]",
         "Variance, clip lengths^2, added to the temporal extent with which Gaussians fade");
}

}  // namespace tessera
