// What: how long each stage of the pipeline takes and how many bytes it had to move.
// Not: a profiler: a backend measures as its device can, the host's clock or the device's events.
#pragma once
#include <array>
#include <chrono>
#include <cstdint>

namespace tessera {

enum Stage : int {
  kProject,
  kBin,
  kBlend,
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
  virtual void end(Stage stage) = 0;
  void add_bytes(Stage stage, double bytes) { totals_[size_t(stage)].bytes += bytes; }
  /// Waits for what is still being measured.
  virtual const std::array<StageTotals, kStages>& totals() = 0;

 protected:
  std::array<StageTotals, kStages> totals_{};
};

/// A stage ends when its function returns.
class HostStageClock final : public StageClock {
 public:
  void begin(Stage) override { begin_ = std::chrono::steady_clock::now(); }
  void end(Stage stage) override {
    totals_[size_t(stage)].seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  const std::array<StageTotals, kStages>& totals() override { return totals_; }

 private:
  std::chrono::steady_clock::time_point begin_;
};

/// Measures the block it lives in.
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
