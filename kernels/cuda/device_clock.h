// Stage times from CUDA events, and NVTX ranges of the same names. One step in `kEvery` is measured
// and stands for the others, because events between kernels cost a few microseconds. A failed
// measurement is left out and never stops a training.
#pragma once
#include <cuda_runtime.h>

#include <vector>

#include "kernels/stage_clock.h"

namespace tessera {

class DeviceStageClock final : public StageClock {
 public:
  explicit DeviceStageClock(cudaStream_t stream) : stream_(stream) {}
  ~DeviceStageClock() override;
  void begin(Stage stage) override;
  const std::array<StageTotals, kStages>& totals() override;

 private:
  struct Span {
    Stage stage;
    double weight;
    cudaEvent_t begin, end;  // end: null while it is open
  };
  void measure(Stage stage) override;
  /// Recorded on the stream. Null: the device refused, and its error is cleared where it can be.
  cudaEvent_t event();
  /// Adds up the spans that have ended, or all of them after waiting; drops those that failed.
  void collect(bool wait);
  void forget(const Span& span);

  /// Odd: calls that alternate between two kinds of work, as in scoring, are both measured.
  static constexpr int64_t kEvery = 9;
  static_assert(kEvery % 2 == 1);
  cudaStream_t stream_;
  int64_t calls_[kStages] = {};
  std::vector<Span> pending_;
  std::vector<cudaEvent_t> spare_;
};

}  // namespace tessera
