// What: training options in the terms of the kernels: forms, switches, what idle Gaussians do.
// Not: what the switches do (kernels/batch.h, kernels/gaussians.h).
#pragma once
#include "kernels/batch.h"
#include "kernels/gaussians.h"
#include "recon4d/options/train_options.h"

namespace tessera {

KernelSwitches kernel_switches(const TrainOptions& options);
/// Of the dynamic set.
SetForm dynamic_form(const TrainOptions& options);

}  // namespace tessera
