// Each event happens once after the same step; training comes when nothing else is left to do.
#include "tools/session/session_events.h"

#include <algorithm>
#include <limits>

namespace tessera {

bool EvaluationPlan::due(int64_t step) const {
  return (every_ > 0 && step % every_ == 0) || std::find(at_.begin(), at_.end(), step) != at_.end();
}

int64_t EvaluationPlan::next_after(int64_t step) const {
  int64_t next = std::numeric_limits<int64_t>::max();
  if (every_ > 0) next = (step / every_ + 1) * every_;
  for (const int64_t at : at_)
    if (at > step) next = std::min(next, at);
  return next;
}

void SessionState::did(SessionEvent event) {
  if (event == SessionEvent::kCheck) checked = step;
  if (event == SessionEvent::kDecide) decided = step;
  if (event == SessionEvent::kSave) saved = step;
  if (event == SessionEvent::kScore) scored = step;
}

SessionEvent next_event(const SessionState& state) {
  const int64_t step = state.step;
  if (!state.leaves) {
    if (state.check_due && state.checked != step) return SessionEvent::kCheck;
    if (state.decided != step) return SessionEvent::kDecide;
  }
  const bool done = step >= state.end || state.stops || state.leaves;
  if ((done || state.save_due) && state.saved != step) return SessionEvent::kSave;
  if (!state.leaves && state.score_due && state.scored != step) return SessionEvent::kScore;
  return done ? SessionEvent::kEnd : SessionEvent::kTrain;
}

}  // namespace tessera
