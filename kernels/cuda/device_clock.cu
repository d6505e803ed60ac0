// What: events around stages, read when they have happened.
// Not: any wait while a training runs.
#include "kernels/cuda/device_clock.h"

#include <nvtx3/nvToolsExt.h>

#include "kernels/cuda/device_error.h"

namespace tessera {

DeviceStageClock::~DeviceStageClock() {
  for (const Span& span : pending_) cudaEventDestroy(span.begin), cudaEventDestroy(span.end);
  for (cudaEvent_t event : spare_) cudaEventDestroy(event);
}

cudaEvent_t DeviceStageClock::event() {
  cudaEvent_t result;
  if (spare_.empty()) {
    check_device(cudaEventCreate(&result), "cudaEventCreate");
  } else {
    result = spare_.back();
    spare_.pop_back();
  }
  check_device(cudaEventRecord(result, stream_), "cudaEventRecord");
  return result;
}

void DeviceStageClock::begin(Stage stage) {
  nvtxRangePushA(kStageNames[stage]);
  // rare stages are measured every time
  const int64_t every = stage == kDensity || stage == kUpdate ? 1 : kEvery;
  open_ = calls_[stage]++ % every == 0;
  if (open_) pending_.push_back({stage, double(every), event(), nullptr});
}

void DeviceStageClock::end(Stage) {
  nvtxRangePop();
  if (open_) pending_.back().end = event();
  open_ = false;
  constexpr size_t kMany = 64;
  if (pending_.size() > kMany) collect(false);
}

void DeviceStageClock::collect(bool wait) {
  std::vector<Span> rest;
  for (const Span& span : pending_) {
    if (wait) check_device(cudaEventSynchronize(span.end), "cudaEventSynchronize");
    if (cudaEventQuery(span.end) == cudaErrorNotReady) {
      rest.push_back(span);
      continue;
    }
    float milliseconds = 0;
    check_device(cudaEventElapsedTime(&milliseconds, span.begin, span.end), "cudaEventElapsedTime");
    totals_[size_t(span.stage)].seconds += 1e-3 * double(milliseconds) * span.weight;
    spare_.push_back(span.begin), spare_.push_back(span.end);
  }
  pending_ = std::move(rest);
}

const std::array<StageTotals, kStages>& DeviceStageClock::totals() {
  collect(true);
  return totals_;
}

}  // namespace tessera
