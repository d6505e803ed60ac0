// A training that can be watched: while RUN/live has a recent request, it writes its progress and
// snapshots of its model there. Without a request it reads one small file each second.
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "recon4d/model/train_state.h"
#include "static3d/tessera4d/tessera4d.h"
#include "tools/live/live_folder.h"
#include "tools/session/session_observer.h"

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

/// Passes what it observes on to another observer. Snapshots come no faster than every three
/// seconds, than they are seen, and than they cost 1 % of the training for the copy and 1 % of the
/// cores for the file (10 % beside a GPU, whose training uses few of the cores).
class LiveTraining final : public SessionObserver, public SnapshotSink {
 public:
  /// `begun` is called once the run folder is there.
  LiveTraining(SessionObserver& inner, const std::filesystem::path& run,
               std::function<void()> begun = {});
  /// Removes RUN/live.
  ~LiveTraining() override;

  void on_message(const std::string& line) override { inner_.on_message(line); }
  void on_warning(const std::string& line) override { inner_.on_warning(line); }
  void on_cuda_unused(const std::string& reason) override { inner_.on_cuda_unused(reason); }
  void on_step(const SessionStep& step) override;
  /// Also after a request to stop, once and for all.
  bool must_stop() override { return stopped_ || inner_.must_stop(); }

  void begin(const Scene& scene, const TrainOptions& options) override;
  bool due() override;
  void take(const TrainState& state) override;

  /// Whether a request, not a signal, has stopped it.
  bool stopped() const { return stopped_; }

 private:
  using Clock = std::chrono::steady_clock;

  void look();
  double pause_between_snapshots() const;  // seconds

  SessionObserver& inner_;
  const LiveFolder folder_;
  const std::function<void()> begun_;
  LiveState state_;
  std::unique_ptr<SnapshotWriter> writer_;
  bool on_device_ = false;
  int64_t copied_step_ = 0;
  Clock::time_point looked_, asked_, taken_;
  int64_t request_counter_ = -1, seen_ = 0;
  bool watched_ = false, stopped_ = false;
  double copy_seconds_ = 0;
};

}  // namespace tessera
