// One job: starts its command, keeps its log, and writes its record when it has ended.
#pragma once
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "tools/jobs/job.h"

namespace tessera {

struct JobOutcome {
  int exit_code = 0;    // 128 + signal where a signal ended it
  std::string message;  // what it said last, where it has failed
  bool out_of_memory = false;
};

/// In a process group of its own: Ctrl-C does not reach it. It holds its log, and by an flock the
/// job, also where this program is killed: a second start waits for it.
class RunningJob {
 public:
  /// `gpu`: the only CUDA device that it sees. Errors: WriteError, InputError: the log cannot be
  /// written.
  RunningJob(const Job& job, const JobFolder& folder, std::optional<int> gpu);
  RunningJob(const RunningJob&) = delete;
  RunningJob& operator=(const RunningJob&) = delete;
  ~RunningJob();

  const Job& job() const { return job_; }
  std::optional<int> gpu() const { return gpu_; }
  /// To the command and what it has started; to no process while it waits for an earlier start.
  void signal(int number) const;
  /// What came of it, once it has ended; its record is written then. Errors: WriteError.
  std::optional<JobOutcome> poll();

 private:
  void start();
  JobOutcome end(int status);
  std::string last_line() const;

  const Job job_;
  const JobFolder folder_;
  const std::optional<int> gpu_;
  int log_ = -1;
  pid_t child_ = -1;
  int64_t log_begin_ = 0, kills_ = 0;  // bytes of the log; programs killed for memory
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace tessera
