// RUN/live: the files by which a training and its viewers communicate. The training opens no
// socket; `tessera view` writes request.json and reads state.json and the snapshots. The format is
// docs/reference/run-folder.md. Also the priority and CPU time of threads beside a training.
#pragma once
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

/// Of a training.
struct LiveState {
  std::string training;  // a new random id for each call of the program
  int64_t counter = 0;   // grows with each writing: by it others see that the training runs
  int64_t step = 0, total = 0;
  double seconds_left = 0, loss = 0, steps_per_second = 0;
  int64_t num_static = 0, num_dynamic = 0, device_bytes = 0;
  int64_t snapshot = 0, snapshot_step = 0;  // number of the newest; 0: none yet
  std::string model_failure;                // why there is no snapshot; "": none failed
};

/// As state.json has it.
std::string text_of(const LiveState& state);

/// A request of a viewer.
struct LiveRequest {
  int64_t counter = 0;        // grows while a viewer is connected
  int64_t seen = 0;           // newest snapshot that was shown
  std::string stop_training;  // id of the training that is to stop; "": none
};

/// Files of one folder, each replaced as a whole.
class LiveFolder {
 public:
  /// Of a run folder.
  explicit LiveFolder(const std::filesystem::path& run) : root_(run / "live") {}
  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path snapshot(int64_t number) const;

  /// For its owner alone. Errors: std::filesystem::filesystem_error.
  void make() const;
  /// With all that is in it; what cannot be removed stays.
  void remove() const;
  /// False where it cannot be written.
  bool write(const LiveState& state) const;
  bool write(const LiveRequest& request) const;
  bool write_snapshot(int64_t number, const std::string& bytes) const;
  /// None where there is none, or it is damaged.
  std::optional<LiveState> state() const;
  std::optional<LiveRequest> request() const;

 private:
  bool replace(const std::filesystem::path& file, const std::string& bytes) const;

  std::filesystem::path root_;
};

/// Of this thread alone: Linux has a priority for each thread. 19: the lowest.
inline void lower_priority(int nice) {
  setpriority(PRIO_PROCESS, id_t(::syscall(SYS_gettid)), nice);
}

/// CPU seconds of this thread so far.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

}  // namespace tessera
