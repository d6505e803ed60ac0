// A loop over the jobs that wait and those that run.
#include "tools/jobs/runner.h"

#include <algorithm>
#include <chrono>
#include <list>
#include <map>
#include <memory>
#include <set>
#include <thread>

namespace tessera {
namespace {

class Runner {
 public:
  Runner(const JobFolder& folder, const JobSlots& slots, const JobsObserver& observer)
      : folder_(folder), observer_(observer), free_(slots) {}

  JobsOutcome run(const std::vector<Job>& jobs) {
    const std::vector<Job> to_do = jobs_to_do(jobs, folder_);
    waiting_.assign(to_do.begin(), to_do.end());
    count_ = int64_t(waiting_.size());
    while (true) {
      pass_signal_on();
      start_what_fits();
      if (running_.empty()) break;
      look();
      tell();
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

  bool may_start(const Job& job) {
    if (std::any_of(job.needs.begin(), job.needs.end(),
                    [&](const auto& need) { return is_waited_for(need); }))
      return false;
    return running_.empty() || (!runs_alone_ && !alone_.contains(job.name) && fits(uses_of(job)));
  }

  /// Asked once, when all that the job needs is done.
  const JobUses& uses_of(const Job& job) {
    const auto known = uses_.find(job.name);
    if (known != uses_.end()) return known->second;
    return uses_[job.name] = observer_.uses ? observer_.uses(job) : job.uses;
  }

  void start(Job job) {
    job.uses = uses_of(job);
    runs_alone_ = alone_.contains(job.name) || !fits(job.uses);
    std::vector<int> gpus;
    for (int64_t i = 0; i < job.uses.gpus && !free_.gpus.empty(); ++i) {
      gpus.push_back(free_.gpus.front());
      free_.gpus.erase(free_.gpus.begin());
    }
    free_.threads -= job.uses.threads;
    free_.memory_mb -= job.uses.memory_mb;
    if (observer_.on_start) observer_.on_start(job, ++number_, count_);
    running_.push_back(std::make_unique<RunningJob>(job, folder_, gpus));
  }

  void look() {
    for (auto running = running_.begin(); running != running_.end();) {
      const std::optional<JobOutcome> outcome = (*running)->poll();
      if (!outcome) {
        ++running;
        continue;
      }
      give_back(**running);
      if (observer_.on_end) observer_.on_end((*running)->job(), *outcome);
      if (outcome->exit_code != 0) fail((*running)->job(), *outcome);
      running = running_.erase(running);
    }
  }

  void tell() {
    constexpr std::chrono::seconds kBetween{1};
    if (!observer_.on_look || running_.empty()) return;
    if (std::chrono::steady_clock::now() - told_ < kBetween) return;
    told_ = std::chrono::steady_clock::now();
    std::vector<std::string> names;
    for (const auto& running : running_) names.push_back(running->job().name);
    observer_.on_look(names);
  }

  void give_back(const RunningJob& running) {
    const JobUses& uses = running.job().uses;
    free_.threads += uses.threads;
    free_.memory_mb += uses.memory_mb;
    free_.gpus.insert(free_.gpus.end(), running.gpus().begin(), running.gpus().end());
    runs_alone_ = false;
  }

  void fail(const Job& job, const JobOutcome& outcome) {
    const bool again = outcome.out_of_memory && passed_on_ == 0 && alone_.insert(job.name).second;
    if (again) {
      waiting_.push_front(job);
      ++count_;
    } else {
      outcome_.failed.push_back(job.name);
    }
  }

  const JobFolder& folder_;
  const JobsObserver& observer_;
  JobSlots free_;
  std::list<Job> waiting_;
  std::list<std::unique_ptr<RunningJob>> running_;
  std::map<std::string, JobUses> uses_;
  std::set<std::string> alone_;  // have run out of memory beside others
  bool runs_alone_ = false;
  int passed_on_ = 0;  // the last signal
  int64_t number_ = 0, count_ = 0;
  std::chrono::steady_clock::time_point told_;
  JobsOutcome outcome_;
};

}  // namespace

JobsOutcome run_jobs(const std::vector<Job>& jobs, const JobFolder& folder, const JobSlots& slots,
                     const JobsObserver& observer) {
  return Runner(folder, slots, observer).run(jobs);
}

}  // namespace tessera
