// What: the statistics of a set begun anew, on the host or a device, and copied.
// Not: who gathers them (kernels/stages).
#include "recon4d/model/set_statistics.h"

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {
void SetStatistics::reset(int64_t gaussians) {
  check(&count.memory() == &host_memory(), "SetStatistics: a device is reset by its backend");
  for (Buffer<float>* values : {&gradient_sum, &count}) {
    values->resize(gaussians);
    std::fill(values->begin(), values->end(), 0.0f);
  }
  filter_size.resize(0);
}

void SetStatistics::reset(Backend& backend, int64_t gaussians) {
  for (Buffer<float>* values : {&gradient_sum, &count}) {
    values->resize(gaussians);
    backend.fill_zero(values->span());
  }
  filter_size.resize(0);
}

SetStatistics SetStatistics::clone_to(Memory& memory) const {
  SetStatistics copy(memory);
  copy.gradient_sum.copy_from(gradient_sum);
  copy.count.copy_from(count);
  copy.filter_size.copy_from(filter_size);
  return copy;
}

}  // namespace tessera
