// Each event happens once after the same step; training comes when nothing else is left to do.
#include "tools/session/clock/session_events.h"

namespace tessera {

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
