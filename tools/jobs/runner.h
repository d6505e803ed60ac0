// Runs a list of jobs on this machine: as many at once as it has room for.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/jobs/job.h"
#include "tools/jobs/perform.h"

namespace tessera {

/// What jobs share. A job that needs more than all of it runs alone.
struct JobSlots {
  std::vector<int> gpus;  // numbers of CUDA devices
  int64_t threads = 1, memory_mb = 0;
};

struct JobsOutcome {
  std::vector<std::string> failed, skipped;  // skipped: what they need has failed
  bool stopped = false;
  bool all_done() const { return failed.empty() && skipped.empty() && !stopped; }
};

struct JobsObserver {
  /// What a job takes, asked once when all that it needs is done; without it what the list states.
  std::function<JobUses(const Job&)> uses;
  std::function<void(const Job&, int64_t number, int64_t count)> on_start;
  std::function<void(const Job&, const JobOutcome&)> on_end;
  /// About once a second, with the names of the jobs that run.
  std::function<void(const std::vector<std::string>& running)> on_look;
  /// Asked ten times a second: a signal for the jobs that run, each of which is passed on once,
  /// after which no job is started; 0: go on.
  std::function<int()> signal;
};

/// Jobs that are done are left as they are. One that fails does not stop those that do not need
/// it; one that has run out of memory is tried once more, alone. Returns when nothing runs. Errors:
/// WriteError, InputError: a record or log cannot be written; jobs that run go on then, and are
/// waited for by the next start.
JobsOutcome run_jobs(const std::vector<Job>& jobs, const JobFolder& folder, const JobSlots& slots,
                     const JobsObserver& observer);

}  // namespace tessera
