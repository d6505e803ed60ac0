// What: how the program ends, as README.md says it.
// Not: what leads to it (main.cpp).
#pragma once

namespace tessera {

enum ExitCode : int {
  kExitDone = 0,
  kExitFailed = 1,
  kExitBadInput = 2,
  kExitNotFinished = 75,  // asked to leave by a scheduler or a time limit: run again to go on
  kExitInterrupted = 130
};

}  // namespace tessera
