// What: the statistics of a set begun anew, on the host or a device, and copied.
// Not: who gathers them (kernels/stages).
#include "recon4d/model/set_statistics.h"

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

void set_steps(Buffer<int32_t>& steps, int64_t count, int64_t step) {
  Buffer<int32_t> filled(count);
  std::fill(filled.begin(), filled.end(), int32_t(step));
  steps.copy_from(filled);
}

}  // namespace

void SetStatistics::reset(int64_t gaussians, int64_t step) {
  check(&count.memory() == &host_memory(), "SetStatistics: a device is reset by its backend");
  for (Buffer<float>* values : {&gradient_sum, &count}) {
    values->resize(gaussians);
    std::fill(values->begin(), values->end(), 0.0f);
  }
  set_steps(sh_step, gaussians, step);
  filter_size.resize(0), anchor.resize(0);
}

void SetStatistics::reset(Backend& backend, int64_t gaussians, int64_t step) {
  for (Buffer<float>* values : {&gradient_sum, &count}) {
    values->resize(gaussians);
    backend.fill_zero(values->span());
  }
  set_steps(sh_step, gaussians, step);
  filter_size.resize(0), anchor.resize(0);
}

SetStatistics SetStatistics::clone_to(Memory& memory) const {
  SetStatistics copy(memory);
  copy.gradient_sum.copy_from(gradient_sum);
  copy.count.copy_from(count);
  copy.sh_step.copy_from(sh_step);
  copy.filter_size.copy_from(filter_size);
  copy.anchor.copy_from(anchor);
  return copy;
}

}  // namespace tessera
