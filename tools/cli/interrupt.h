// Signals that stop the program, and its exit codes. Ctrl-C (SIGINT), the signals of a scheduler
// (SIGTERM, SIGUSR1) and of a closed terminal (SIGHUP) set a flag that long work polls; a second
// Ctrl-C ends the program at once.
#pragma once
#include <exception>

namespace tessera {

/// Thrown by work that has no other way to stop; main() converts it into stop_code().
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

void install_interrupt_handlers();
bool interrupted();
/// For progress callbacks. Errors: Interrupted.
void stop_if_interrupted();
/// The exit code of what was stopped before its end: 130 after Ctrl-C, else 75: to be run again.
int stop_code();
/// What stopped this program, for those that it has started: SIGINT, SIGTERM, or 0.
int stop_signal();

enum ExitCode : int {
  kExitDone = 0,
  kExitFailed = 1,
  kExitBadInput = 2,
  kExitCheckpointRefused = 65,  // train --resume: the checkpoint does not fit this scene or program
  kExitNotFinished = 75,        // stopped by a scheduler or a time limit: run again to resume
  kExitInterrupted = 130
};

}  // namespace tessera
