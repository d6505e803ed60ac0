// One job: starts its command, keeps its log, and writes its record when it has ended.
#pragma once
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/jobs/job.h"

namespace tessera {

struct JobOutcome {
  int exit_code = 0;    // 128 + signal where a signal ended it
  std::string message;  // what it said last, where it has failed
  bool out_of_memory = false;
};

/// What a log from that byte on says last: its line of an error where there is one, or "".
std::string last_line(const std::filesystem::path& log, int64_t begin = 0);

/// The record of a job that was never started. Errors: WriteError.
void record_refusal(const Job& job, const JobFolder& folder, const std::string& message);

/// In a process group of its own: Ctrl-C does not reach it. It holds its log, and by an flock the
/// job, also where this program is killed: a second start waits for it, and is done with it where
/// the first was.
class RunningJob {
 public:
  /// `gpus`: of the CUDA devices that this program sees, those that the command sees; none: all.
  /// Errors: WriteError, InputError: the log cannot be written.
  RunningJob(const Job& job, const JobFolder& folder, const std::vector<int>& gpus);
  RunningJob(const RunningJob&) = delete;
  RunningJob& operator=(const RunningJob&) = delete;
  ~RunningJob();

  const Job& job() const { return job_; }
  const std::vector<int>& gpus() const { return gpus_; }
  /// To the command and what it has started; to no process while it waits for an earlier start.
  void signal(int number) const;
  /// What came of it, once it has ended; its record is written then. Errors: WriteError.
  std::optional<JobOutcome> poll();

 private:
  void start();
  JobOutcome end(int status);

  const Job job_;
  const JobFolder folder_;
  const std::vector<int> gpus_;
  int log_ = -1;
  pid_t child_ = -1;
  int64_t log_begin_ = 0, kills_ = 0;  // bytes of the log; programs killed for memory
  double seconds_before_ = 0;          // of earlier starts with the same inputs
  bool was_done_ = false, has_waited_ = false;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace tessera
