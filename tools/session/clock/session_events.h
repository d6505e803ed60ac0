// When a training session saves and evaluates, and the order of all that it does, of what is due
// and what is done.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "tools/session/clock/time_limit.h"

namespace tessera {

/// After so many steps, or by the clock, so that writing never takes more than a twentieth of the
/// time.
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

/// Of `evaluate_every`: what comes after the training scores its model.
constexpr int64_t kNeverEvaluate = -1;

/// The steps after which the model is scored on held-out views.
class EvaluationPlan {
 public:
  /// `every`: steps between two; 0: at the end alone; kNeverEvaluate.
  explicit EvaluationPlan(int64_t every) : every_(every) {}

  bool due(int64_t step) const { return every_ > 0 && step % every_ == 0; }
  bool at_end() const { return every_ != kNeverEvaluate; }
  /// The first step after `step`; the largest number where there is none.
  int64_t next_after(int64_t step) const {
    return every_ > 0 ? (step / every_ + 1) * every_ : std::numeric_limits<int64_t>::max();
  }

 private:
  int64_t every_;
};

enum class SessionEvent { kTrain, kCheck, kDecide, kSave, kScore, kEnd };

/// Where a session is between two events.
struct SessionState {
  int64_t step = 0, end = 0;  // steps taken, and those at which this call ends
  bool leaves = false;        // before the end: it saves, and a later call resumes
  bool stops = false;         // validation has ended the training
  bool check_due = false, save_due = false, score_due = false;
  // the steps after which it was last done in this call
  int64_t checked = -1, decided = -1, saved = -1, scored = -1;

  /// Marks the event as done after `step` steps.
  void did(SessionEvent event);
};

/// After a stretch of training: the check on validation views, the decision that depends on it, the
/// checkpoint that has both, and the scores, which a resumed session can repeat. A session that
/// leaves saves first and does nothing else.
SessionEvent next_event(const SessionState& state);

}  // namespace tessera
