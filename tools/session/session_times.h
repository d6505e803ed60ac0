// Wall time of a training by kind of work, and time and memory of the stages of its steps (failure
// mode D7). kernels/stage_clock.h has the clocks.
#pragma once
#include <array>
#include <nlohmann/json_fwd.hpp>

#include "kernels/backend.h"
#include "kernels/base/seconds_since.h"

namespace tessera {

/// Wall time by kind, seconds. Evaluation is off the clock of training.
class WallSplit {
 public:
  enum Kind { kLoad, kInit, kTrain, kEvaluate, kSave, kKinds };

  /// Counts what `work` takes, also where it throws; returns what it returns.
  template <class Work>
  auto time(Kind kind, Work&& work) {
    const Span span(seconds_[kind]);
    return work();
  }
  /// {load, init, train, evaluate, save}
  nlohmann::json json() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Span {
    explicit Span(double& seconds) : sum(seconds), begin(Clock::now()) {}
    Span(const Span&) = delete;
    ~Span() { sum += seconds_since(begin); }
    double& sum;
    Clock::time_point begin;
  };
  std::array<double, kKinds> seconds_{};
};

/// Stages and memory of steps and decisions; evaluations use the same backend and are left out.
class StageLog {
 public:
  explicit StageLog(Backend& backend) : memory_(backend.memory()), clock_(backend.clock()) {}

  /// Counts what `work` does.
  template <class Work>
  void count(Work&& work) {
    const std::array<StageTotals, kStages> before = clock_.totals();
    work();
    add(before);
  }
  /// stage_ms, stage_gbytes, stage_gb_per_s, peak_device_bytes.
  void add_to(nlohmann::json& result) const;

 private:
  /// What came after `before`.
  void add(const std::array<StageTotals, kStages>& before);

  Memory& memory_;
  StageClock& clock_;
  std::array<StageTotals, kStages> sum_{};
  int64_t peak_ = 0;  // before the evaluation that follows the last stretch
};

}  // namespace tessera
