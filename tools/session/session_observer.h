// What: what a training session reports while it runs, and the question whether it is to stop.
// Not: how that is shown (tools/cli/training_terminal.h), nor the log in the run folder, which the
//      session writes itself.
#pragma once
#include <cstdint>
#include <string>

#include "recon4d/training/trainer.h"

namespace tessera {

struct SessionStep {
  const StepReport& report;
  int64_t total = 0, first = 0;  // steps of the training; steps done before this session
  double steps_per_second = 0;   // over the steps since the last line of the log
};

class SessionObserver {
 public:
  virtual ~SessionObserver() = default;
  /// One line of text.
  virtual void on_message(const std::string&) {}
  virtual void on_warning(const std::string&) {}
  /// The session uses the CPU although the machine looks as if CUDA could be used.
  virtual void on_cuda_unused(const std::string& /*reason*/) {}
  virtual void on_step(const SessionStep&) {}
  /// Asked before each step and between stages. After true the session saves and returns.
  virtual bool must_stop() { return false; }
};

}  // namespace tessera
