// Construction and name of the CPU backends.
#include "kernels/cpu_backend.h"

#include "kernels/base/parallel.h"

namespace tessera {

template <class Real>
std::string CpuBackend<Real>::name() const {
  const int threads = thread_count();
  return "cpu, " + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

template <class Real>
StepOutcome CpuBackend<Real>::outcome() {
  return outcome_;
}

template std::string CpuBackend<float>::name() const;
template std::string CpuBackend<double>::name() const;
template StepOutcome CpuBackend<float>::outcome();
template StepOutcome CpuBackend<double>::outcome();

std::unique_ptr<Backend> make_cpu_backend() {
  return std::make_unique<CpuBackend<float>>();
}

}  // namespace tessera
