// What: when a training writes its next checkpoint: after so many steps, or by the clock, so that
// writing never takes more than a twentieth of the time.
// Not: writing it (train_session.cpp).
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "tools/session/time_limit.h"

namespace tessera {

class CheckpointPlan {
 public:
  static constexpr double kLeastSeconds = 60;   // between two, by the clock
  static constexpr double kLeastMultiple = 20;  // of the time that the last one took

  /// `every`: steps between two; 0: none before the end; without a value: by the clock.
  CheckpointPlan(std::optional<int64_t> every, Stopwatch now)
      : every_(every.value_or(kByClock)), now_(std::move(now)) {}

  /// Before the first step, from a state that needs no saving.
  void begin(int64_t step) {
    step_ = step;
    saved_ = now_();
  }
  bool due(int64_t step) const {
    if (step == step_) return false;
    if (every_ != kByClock) return every_ > 0 && step % every_ == 0;
    return now_() - saved_ >= std::max(kLeastSeconds, kLeastMultiple * seconds_);
  }
  /// The step after `step` at which one is due; the largest number where steps do not say.
  int64_t next_after(int64_t step) const {
    if (every_ <= 0) return std::numeric_limits<int64_t>::max();
    return (step / every_ + 1) * every_;
  }
  template <class Work>
  void save(int64_t step, Work&& work) {
    const double begin = now_();
    work();
    step_ = step;
    saved_ = now_();
    seconds_ = saved_ - begin;
  }

 private:
  static constexpr int64_t kByClock = -1;

  int64_t every_;
  Stopwatch now_;
  int64_t step_ = 0;                // of the last
  double saved_ = 0, seconds_ = 0;  // when it was written, and for how long
};

}  // namespace tessera
