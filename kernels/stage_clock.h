// The time that each stage of the pipeline takes, and the bytes that it has to move, by the clock
// of the host or by events of the device. Timers may nest; the time of the inner one then counts in
// both stages.
#pragma once
#include <array>
#include <chrono>
#include <cstdint>

#include "kernels/base/seconds_since.h"

namespace tessera {

enum Stage : int {
  kProject,
  kBin,
  kBlend,  // and the environment behind
  kPhotometric,
  kBlendBackward,
  kProjectBackward,
  kUpdate,   // Adam as a stage of its own, SH catching up
  kDensity,  // density control and ordering
  kStages
};
inline constexpr const char* kStageNames[kStages] = {
    "project",          "bin",    "blend",  "photometric", "blend_backward",
    "project_backward", "update", "density"};

/// Totals since construction. `bytes` are counted from sizes, each array read or written once.
struct StageTotals {
  double seconds = 0;
  double bytes = 0;
};

class StageClock {
 public:
  virtual ~StageClock() = default;
  virtual void begin(Stage stage) = 0;
  /// Ends what the last open `begin(stage)` began. Destructors call it, also while the error of a
  /// stage is on its way to the caller: a span that cannot be measured is dropped.
  void end(Stage stage) noexcept {
    try {
      measure(stage);
    } catch (...) {  // the stage's own error is the one to report
    }
  }
  void add_bytes(Stage stage, double bytes) { totals_[size_t(stage)].bytes += bytes; }
  /// Waits for what is still being measured.
  virtual const std::array<StageTotals, kStages>& totals() = 0;

 protected:
  /// What `end` does. May throw.
  virtual void measure(Stage stage) = 0;

  std::array<StageTotals, kStages> totals_{};
};

/// A stage ends when its function returns.
class HostStageClock final : public StageClock {
 public:
  void begin(Stage stage) override { begin_[stage] = std::chrono::steady_clock::now(); }
  const std::array<StageTotals, kStages>& totals() override { return totals_; }

 private:
  void measure(Stage stage) override {
    totals_[size_t(stage)].seconds += seconds_since(begin_[stage]);
  }

  std::chrono::steady_clock::time_point begin_[kStages];
};

/// Measures the block in which it is declared.
class StageTimer {
 public:
  StageTimer(StageClock& clock, Stage stage) : clock_(clock), stage_(stage) { clock.begin(stage); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() { clock_.end(stage_); }

 private:
  StageClock& clock_;
  Stage stage_;
};

}  // namespace tessera
