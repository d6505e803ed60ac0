// CUDA events around stages, which are read after they have happened, so that a training does not
// wait for them.
#include "kernels/cuda/device_clock.h"

#include <nvtx3/nvToolsExt.h>

#include <utility>

namespace tessera {

DeviceStageClock::~DeviceStageClock() {
  for (const Span& span : pending_) forget(span);
  for (cudaEvent_t event : spare_) cudaEventDestroy(event);
}

void DeviceStageClock::forget(const Span& span) {
  cudaEventDestroy(span.begin);
  if (span.end != nullptr) cudaEventDestroy(span.end);
}

cudaEvent_t DeviceStageClock::event() {
  cudaEvent_t result = nullptr;
  if (!spare_.empty()) {
    result = spare_.back();
    spare_.pop_back();
  } else if (cudaEventCreate(&result) != cudaSuccess) {
    cudaGetLastError();
    return nullptr;
  }
  if (cudaEventRecord(result, stream_) == cudaSuccess) return result;
  cudaGetLastError();
  cudaEventDestroy(result);
  return nullptr;
}

void DeviceStageClock::begin(Stage stage) {
  nvtxRangePushA(kStageNames[stage]);
  // rare stages are measured every time
  const int64_t every = stage == kDensity || stage == kUpdate ? 1 : kEvery;
  if (calls_[stage]++ % every != 0) return;
  if (const cudaEvent_t begun = event()) pending_.push_back({stage, double(every), begun, nullptr});
}

void DeviceStageClock::measure(Stage stage) {
  nvtxRangePop();
  for (size_t i = pending_.size(); i-- > 0;) {
    Span& span = pending_[i];
    if (span.stage != stage || span.end != nullptr) continue;
    span.end = event();
    if (span.end == nullptr) {
      forget(span);
      pending_.erase(pending_.begin() + std::ptrdiff_t(i));
    }
    break;
  }
  constexpr size_t kMany = 64;
  if (pending_.size() > kMany) collect(false);
}

void DeviceStageClock::collect(bool wait) {
  std::vector<Span> rest;
  for (const Span& span : std::exchange(pending_, {})) {
    const cudaError_t state = span.end == nullptr ? cudaErrorNotReady
                              : wait              ? cudaEventSynchronize(span.end)
                                                  : cudaEventQuery(span.end);
    if (state == cudaErrorNotReady) {
      rest.push_back(span);
      continue;
    }
    float milliseconds = 0;
    if (state != cudaSuccess ||
        cudaEventElapsedTime(&milliseconds, span.begin, span.end) != cudaSuccess) {
      forget(span);
      cudaGetLastError();
      continue;
    }
    totals_[size_t(span.stage)].seconds += 1e-3 * double(milliseconds) * span.weight;
    spare_.push_back(span.begin);
    spare_.push_back(span.end);
  }
  pending_ = std::move(rest);
}

const std::array<StageTotals, kStages>& DeviceStageClock::totals() {
  collect(true);
  return totals_;
}

}  // namespace tessera
