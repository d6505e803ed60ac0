// What: names of the option table → values of the kernels.
// Not: defaults; those of TrainOptions are the kernels'.
#include "recon4d/options/kernel_options.h"

#include "kernels/base/errors.h"

namespace tessera {
namespace {

BackwardForm backward_form(const std::string& name) {
  if (name == "pixel") return BackwardForm::kPixel;
  check(name == "sub-tile", "an unknown form of the backward pass");
  return BackwardForm::kSubTile;
}

}  // namespace

KernelSwitches kernel_switches(const TrainOptions& options) {
  KernelSwitches switches;
  switches.bounds.rectangular = options.rectangular_bounds;
  switches.bounds.opacity_aware = options.opacity_bounds;
  switches.balanced_instances = options.balanced_instances;
  switches.separate_sort = options.separate_sort;
  switches.warp_culling = options.warp_culling;
  switches.backward = backward_form(options.backward);
  switches.deterministic = options.deterministic;
  return switches;
}

Form dynamic_form(const TrainOptions& options) {
  if (options.motion_form == "velocity") return Form::kVelocity;
  check(options.motion_form == "pair", "an unknown form of dynamic Gaussians");
  return Form::kPair;
}

IdleUpdate idle_update(const TrainOptions& options) {
  if (options.idle_updates == "skip") return IdleUpdate::kSkip;
  check(options.idle_updates == "dense", "an unknown update of idle Gaussians");
  return IdleUpdate::kDense;
}

}  // namespace tessera
