// Wall time of a training by kind of work, and time and memory of the stages of its steps (failure
// mode D7). kernels/stage_clock.h has the clocks.
#pragma once
#include <array>
#include <nlohmann/json_fwd.hpp>

#include "kernels/backend.h"
#include "kernels/base/seconds_since.h"

namespace tessera {

/// Wall time by kind, seconds; each second counts for one kind. Evaluation is off the clock of
/// training.
class WallSplit {
 public:
  /// kLoad: reading, but for what is read while the device starts; kDevice: its choice and start;
  /// kCloud: of a scene without points; kTrial: of motion; kInit: what is left before the first
  /// step, as masks and uploads; kUnseen: removal of what no view shows; kDecide: on motion and
  /// size.
  enum Kind {
    kLoad,
    kDevice,
    kCloud,
    kTrial,
    kInit,
    kSteps,
    kUnseen,
    kDecide,
    kEvaluate,
    kSave,
    kKinds
  };

  /// Counts what `work` takes, also where it throws; returns what it returns. Work in it that is
  /// timed as another kind counts for that kind alone.
  template <class Work>
  auto time(Kind kind, Work&& work) {
    const Span span(*this, kind);
    return work();
  }
  /// Counts seconds of one kind as another.
  void move(Kind from, Kind to, double seconds) {
    seconds_[from] -= seconds;
    seconds_[to] += seconds;
  }
  /// {load, device, cloud, trial, init, steps, unseen, decisions, evaluate, save}
  nlohmann::json json() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Span {
    Span(WallSplit& of, Kind kind) : split(of), outer(of.running_) { split.go_on_as(kind); }
    Span(const Span&) = delete;
    ~Span() { split.go_on_as(outer); }
    WallSplit& split;
    Kind outer;
  };
  void go_on_as(Kind kind) {
    if (running_ != kKinds) seconds_[running_] += seconds_since(since_);
    running_ = kind;
    since_ = Clock::now();
  }

  std::array<double, kKinds> seconds_{};
  Kind running_ = kKinds;  // none
  Clock::time_point since_;
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
