// A loop over the jobs that wait and those that run.
#include "tools/jobs/runner.h"

#include <algorithm>
#include <chrono>
#include <list>
#include <memory>
#include <set>
#include <thread>

namespace tessera {
namespace {

class Runner {
 public:
  Runner(const JobFolder& folder, const JobSlots& slots, const JobsObserver& observer)
      : folder_(folder), slots_(slots), observer_(observer), free_(slots) {}

  JobsOutcome run(const std::vector<Job>& jobs) {
    std::set<std::string> stale;
    for (const Job& job : jobs) {
      const bool again = std::any_of(job.needs.begin(), job.needs.end(),
                                     [&](const auto& need) { return stale.contains(need); });
      if (!again && is_done(job, folder_)) continue;
      stale.insert(job.name);
      waiting_.push_back(job);
    }
    count_ = int64_t(waiting_.size());
    while (true) {
      pass_signal_on();
      start_what_fits();
      if (running_.empty()) break;
      look();
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return outcome_;
  }

 private:
  void pass_signal_on() {
    const int number = observer_.signal ? observer_.signal() : 0;
    if (number == 0 || number == passed_on_) return;
    passed_on_ = number;
    outcome_.stopped = outcome_.stopped || !running_.empty() || !waiting_.empty();
    for (const auto& job : running_) job->signal(number);
  }

  bool is_waited_for(const std::string& need) const {
    const auto is_it = [&](const Job& job) { return job.name == need; };
    return std::any_of(waiting_.begin(), waiting_.end(), is_it) ||
           std::any_of(running_.begin(), running_.end(),
                       [&](const auto& running) { return is_it(running->job()); });
  }

  static bool is_among(const std::string& name, const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }

  bool fits(const JobUses& uses) const {
    return int64_t(free_.gpus.size()) >= uses.gpus && free_.threads >= uses.threads &&
           free_.memory_mb >= uses.memory_mb;
  }

  void start_what_fits() {
    if (passed_on_ != 0) return;
    for (auto job = waiting_.begin(); job != waiting_.end();) {
      const bool is_lost = std::any_of(job->needs.begin(), job->needs.end(), [&](const auto& need) {
        return is_among(need, outcome_.failed) || is_among(need, outcome_.skipped);
      });
      if (is_lost) {
        outcome_.skipped.push_back(job->name);
        job = waiting_.erase(job);
        continue;
      }
      if (!may_start(*job)) {
        ++job;
        continue;
      }
      start(*job);
      job = waiting_.erase(job);
    }
  }

  bool may_start(const Job& job) const {
    if (std::any_of(job.needs.begin(), job.needs.end(),
                    [&](const auto& need) { return is_waited_for(need); }))
      return false;
    return running_.empty() || (!runs_alone_ && !alone_.contains(job.name) && fits(job.uses));
  }

  void start(const Job& job) {
    runs_alone_ = alone_.contains(job.name) || !fits(job.uses);
    std::optional<int> gpu;
    if (job.uses.gpus > 0 && !free_.gpus.empty()) {
      if (slots_.gpus.size() > 1) gpu = free_.gpus.front();
      free_.gpus.erase(free_.gpus.begin());
    }
    free_.threads -= job.uses.threads;
    free_.memory_mb -= job.uses.memory_mb;
    if (observer_.on_start) observer_.on_start(job, ++number_, count_);
    running_.push_back(std::make_unique<RunningJob>(job, folder_, gpu));
  }

  void look() {
    for (auto running = running_.begin(); running != running_.end();) {
      const std::optional<JobOutcome> outcome = (*running)->poll();
      if (!outcome) {
        ++running;
        continue;
      }
      give_back(**running);
      if (outcome->exit_code != 0) fail((*running)->job(), *outcome);
      running = running_.erase(running);
    }
  }

  void give_back(const RunningJob& running) {
    const JobUses& uses = running.job().uses;
    free_.threads += uses.threads;
    free_.memory_mb += uses.memory_mb;
    if (uses.gpus > 0 && free_.gpus.size() < slots_.gpus.size())
      free_.gpus.push_back(running.gpu().value_or(slots_.gpus.front()));
    runs_alone_ = false;
  }

  void fail(const Job& job, const JobOutcome& outcome) {
    const bool again = outcome.out_of_memory && passed_on_ == 0 && alone_.insert(job.name).second;
    if (observer_.on_failure) observer_.on_failure(job, outcome);
    if (again) {
      waiting_.push_front(job);
      ++count_;
    } else {
      outcome_.failed.push_back(job.name);
    }
  }

  const JobFolder& folder_;
  const JobSlots& slots_;
  const JobsObserver& observer_;
  JobSlots free_;
  std::list<Job> waiting_;
  std::list<std::unique_ptr<RunningJob>> running_;
  std::set<std::string> alone_;  // have run out of memory beside others
  bool runs_alone_ = false;
  int passed_on_ = 0;  // the last signal
  int64_t number_ = 0, count_ = 0;
  JobsOutcome outcome_;
};

}  // namespace

JobsOutcome run_jobs(const std::vector<Job>& jobs, const JobFolder& folder, const JobSlots& slots,
                     const JobsObserver& observer) {
  return Runner(folder, slots, observer).run(jobs);
}

}  // namespace tessera
