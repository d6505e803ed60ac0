// What: stage times by the device's own events, and NVTX ranges of the same names.
// Not: exact for every step: one step in `kEvery` is measured and stands for the others, because
// events between kernels cost a few microseconds.
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
  void end(Stage stage) override;
  const std::array<StageTotals, kStages>& totals() override;

 private:
  struct Span {
    Stage stage;
    double weight;
    cudaEvent_t begin, end;
  };
  cudaEvent_t event();
  void collect(bool wait);

  static constexpr int64_t kEvery = 8;
  cudaStream_t stream_;
  int64_t calls_[kStages] = {};
  bool open_ = false;
  std::vector<Span> pending_;
  std::vector<cudaEvent_t> spare_;
};

}  // namespace tessera
