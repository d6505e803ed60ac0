// What: the error of a checkpoint that no training can go on from, however often it is tried.
// Not: files that cannot be read at the moment (InputError).
#pragma once
#include "kernels/base/errors.h"

namespace tessera {

/// The file was read, but it is no checkpoint, of another version, truncated, damaged, or of
/// another scene or training.
class CheckpointRefused : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace tessera
