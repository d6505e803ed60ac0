// What: names of the option table → values of the kernels.
// Not: defaults; those of TrainOptions are the kernels'.
#include "recon4d/options/kernel_options.h"

namespace tessera {

KernelSwitches kernel_switches(const TrainOptions& options) {
  KernelSwitches switches;
  switches.bounds.rectangular = options.rectangular_bounds;
  switches.bounds.opacity_aware = options.opacity_bounds;
  switches.balanced_instances = options.balanced_instances;
  switches.separate_sort = options.separate_sort;
  switches.warp_culling = options.warp_culling;
  switches.backward = options.backward;
  switches.deterministic = options.deterministic;
  return switches;
}

SetForm dynamic_form(const TrainOptions& options) {
  return dynamic_form_of(options.motion);
}

}  // namespace tessera
