// The CPU backend in float (production) and double (reference). Each stage is defined in the file
// of its name in stages/, edits/ or measures/.
#pragma once
#include "kernels/backend.h"

namespace tessera {

template <class Real>
class CpuBackend : public BackendOf<Real> {
 public:
  std::string name() const override;
  Memory& memory() override { return host_memory(); }
  StageClock& clock() override { return clock_; }
#define OPERATION(result, name, parameters, names) result name parameters override;
#include "kernels/operations.inc"

 private:
  HostStageClock clock_;
  StepOutcome outcome_;
  Buffer<Real> environment_parts_;                         // [parts] gradients of a map each
  Buffer<SplatMoments<Real>> instance_gradients_;          // [I] by slot, summed per splat in order
  Buffer<MomentsAndLength<Real>> instance_lengths_;        // likewise, where lengths are wanted
  Buffer<SplatSensitivity<Real>> instance_sensitivities_;  // the same
};

}  // namespace tessera
