// What: what a training tells the outside, as plain data; tools/ prints and logs it.
// Not: control: stopping is the caller's (Trainer::run returns after the steps asked for).
#pragma once
#include <cstdint>
#include <string>

#include "recon4d/density/density.h"

namespace tessera {

struct StepReport {
  int64_t iteration = 0;              // steps done, this one included
  double loss = 0, l1 = 0, ssim = 0;  // mean over the batch
  int64_t num_static = 0, num_dynamic = 0;
  int64_t splats = 0, instances = 0, invalid_gaussians = 0;
  int64_t pixels = 0;      // of the batch
  int64_t peak_bytes = 0;  // of the backend's memory, so far
  double seconds = 0;      // since the report before, or since `run` began
};

class Observer {
 public:
  virtual ~Observer() = default;
  /// In the order of steps; up to one step late, but before `run` returns.
  virtual void on_step(const StepReport&) {}
  /// After a density control; `set` is "static" or "dynamic".
  virtual void on_density(int64_t, const std::string&, const DensityReport&) {}
};

}  // namespace tessera
