// Copies of the model as files for a player, made beside the training.
#pragma once
#include <atomic>
#include <optional>
#include <string>
#include <thread>

#include "recon4d/model/train_state.h"
#include "static3d/tessera4d/tessera4d.h"
#include "tools/live/live_folder.h"

namespace tessera {

/// One at a time, on one thread of low priority, which uses one core.
class SnapshotWriter {
 public:
  SnapshotWriter(LiveFolder folder, TrainOptions options, Tessera4dOptions file);
  ~SnapshotWriter();  // waits for the one that is being written

  bool busy() const { return busy_; }
  /// Bakes, encodes and writes the model of `state`, whose values are in the host's memory, and
  /// removes the snapshot before the last. Not while busy().
  void start(TrainState state, int64_t number);
  /// Number of the newest that was written; 0: none.
  int64_t written() const { return written_; }
  /// CPU seconds of the last.
  double seconds() const { return seconds_; }
  /// Why the last could not be written; "" where it was. Not while busy().
  const std::string& failure() const { return failure_; }

 private:
  void write(TrainState& state, int64_t number);

  const LiveFolder folder_;
  const TrainOptions options_;
  const Tessera4dOptions file_;
  std::thread thread_;
  std::atomic<bool> busy_{false};
  std::atomic<int64_t> written_{0};
  std::atomic<double> seconds_{0};
  std::string failure_;
};

}  // namespace tessera
