// What: how the program ends, as README.md says it.
// Not: what leads to it (main.cpp).
#pragma once

namespace tessera {

enum ExitCode : int {
  kExitDone = 0,
  kExitFailed = 1,
  kExitBadInput = 2,
  kExitCheckpointRefused = 65,  // train --resume: the checkpoint does not fit this scene or program
  kExitNotFinished = 75,        // asked to leave by a scheduler or a time limit: run again to go on
  kExitInterrupted = 130
};

}  // namespace tessera
