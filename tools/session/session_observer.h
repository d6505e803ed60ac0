// What a training session reports while it runs, and who may stop it or take copies of its model.
// The session writes the log of the run folder itself.
#pragma once
#include <cstdint>
#include <string>

#include "recon4d/training/trainer.h"

namespace tessera {

struct SessionStep {
  const StepReport& report;
  int64_t total = 0, first = 0;  // steps of the training; steps done before this session
  double steps_per_second = 0;   // over the steps since the last line of the log
  double seconds_left = 0;       // by all of this session so far, decisions too
};

/// What `rest` steps will take, where `done` have taken `seconds`.
inline double seconds_left(double seconds, int64_t done, int64_t rest) {
  return seconds * double(rest) / double(done);
}

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

/// Receives the model between two steps, while it trains.
class SnapshotSink {
 public:
  virtual ~SnapshotSink() = default;
  /// Once, before the first step. Images of `scene` are in memory; nothing of it is kept.
  virtual void begin(const Scene& scene, const TrainOptions& options) = 0;
  /// Asked before each step: whether the training is to stop for take().
  virtual bool due() = 0;
  /// `state` is in the backend's memory, and changes after the call.
  virtual void take(const TrainState& state) = 0;
};

}  // namespace tessera
