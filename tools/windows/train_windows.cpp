// What a job makes is known by the request of the plan: the folder may be moved.
#include "tools/windows/train_windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/background_program.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/run_record.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/training_terminal.h"
#include "tools/jobs/runner.h"
#include "tools/live/earlier_training.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/windows/windows_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kScene = "static-scene";
constexpr const char* kStatic = "static";

std::string window_job(int64_t index) {
  return fmt::format("window-{}", index + 1);
}

/// A message of this program's, within another one.
std::string without_name(const std::string& message) {
  constexpr std::string_view kName = "tessera: ";
  return message.starts_with(kName) ? message.substr(kName.size()) : message;
}

class WindowsTraining {
 public:
  explicit WindowsTraining(const WindowsRequest& request)
      : request_(request),
        folder_{fs::absolute(request.root)},
        jobs_{folder_.root, this_program()},
        planned_(resolve_options(request.arguments, request.scene)) {}

  json run() {
    RunLock lock(request_.root, terminal_);
    JobsOutcome outcome;
    const bool done_before = is_done(lock);
    if (!done_before) {
      forget_checkpoints();
      const std::vector<Job> jobs = list();
      write_job_list(jobs, jobs_);
      outcome = run_jobs(jobs, jobs_, slots(), observer());
      bar_.reset();
      forget_checkpoints();
    }
    json result = windows_result(folder_);
    result["finished"] = outcome.all_done();
    result["left"] = outcome.stopped;
    result["continued"] = continues_;
    if (done_before) result["done_before"] = true;
    if (outcome.stopped && !interrupted()) check_progress();
    if (!outcome.stopped && !outcome.all_done()) refuse(outcome);
    return result;
  }

 private:
  /// Of the same request; that of another one is refused, or kept as ROOT.1 where that is asked.
  bool is_done(RunLock& lock) {
    json asked = asked_of_training(request_.arguments, planned_);
    asked[kSceneFiles] = request_.files;
    asked[kWindows] = request_.count;
    const RunRecord record = record_of(RunFolder{folder_.root}, request_.scene);
    const RunAction action = action_in(folder_.root, record, asked, request_.overwrite);
    if (action == RunAction::kReplace) lock.make_room();
    continues_ = WindowsFolder::is_finished(folder_.static_run());
    const std::string scene = fs::absolute(request_.scene).string();
    if (folder_.exists()) {
      plan_ = folder_.read();
      if (plan_.scene != scene) {  // it may have been moved
        plan_.scene = scene;
        folder_.write(plan_);
      }
    } else {
      make_plan(scene, std::move(asked));
      folder_.write(plan_);
    }
    return action == RunAction::kDone;
  }

  void make_plan(const std::string& scene, json asked) {
    const RunFolder whole{folder_.root};
    whole.require_room();
    whole.remove_files();  // of a training that was only begun
    if (!request_.reason.empty()) say(request_.reason);
    const Scene clip = scene_without_pixels(request_.scene, false);
    plan_.scene = scene;
    plan_.clip = clip.time_axis;
    plan_.windows = cut_clip(clip, request_.count, plan_.overlap);
    plan_.request = std::move(asked);
  }

  std::vector<RunFolder> trainings() const {
    std::vector<RunFolder> runs{RunFolder{folder_.static_run()}};
    for (int64_t i = 0; i < request_.count; ++i) runs.push_back(RunFolder{folder_.window_run(i)});
    return runs;
  }

  /// Checkpoints of what is finished: a window without one is done (windows_folder.h).
  void forget_checkpoints() const {
    std::error_code ignored;
    for (const RunFolder& run : trainings())
      if (record_of(run, request_.scene).finished) fs::remove(run.checkpoint(), ignored);
  }

  /// A limit that every call reaches before its first step would be resumed for ever.
  void check_progress() const {
    const auto is_new = [&](const RunFolder& run) {
      std::error_code absent;
      const auto written = fs::last_write_time(run.checkpoint(), absent);
      return !absent && written >= begin_;
    };
    const std::vector<RunFolder> runs = trainings();
    if (done_ > 0 || std::any_of(runs.begin(), runs.end(), is_new)) return;
    throw InputError(fmt::format(
        "--time-limit: {:g} s leave room for no step beside loading and saving; pass a longer "
        "one",
        request_.time_limit));
  }

  std::vector<Job> list() const {
    const std::string scene = folder_.static_scene().string(),
                      fixed = folder_.static_run().string();
    std::vector<Job> jobs;
    jobs.push_back(job(kScene, {"unpack", plan_.scene, "-o", scene, "--static", "--overwrite"}, {},
                       folder_.static_scene() / "transforms.json"));
    jobs.push_back(training(kStatic, {scene, "-o", fixed}, half_limits(), {kScene},
                            RunFolder{folder_.static_run()}));
    for (int64_t i = 0; i < request_.count; ++i) {
      const RunFolder run{folder_.window_run(i)};
      jobs.push_back(training(window_job(i),
                              {plan_.scene, "-o", run.root.string(), "--window",
                               text_of(plan_.window(i)), "--static-model", fixed},
                              request_.arguments, {kStatic}, run));
    }
    return jobs;
  }

  Job training(const std::string& name, const std::vector<std::string>& what,
               const TrainArguments& arguments, std::vector<std::string> needs,
               const RunFolder& run) const {
    std::vector<std::string> words{"train"};
    for (const std::vector<std::string>& more :
         {what, words_of(arguments), backend_words(arguments.backend)})
      words.insert(words.end(), more.begin(), more.end());
    Job training = job(name, std::move(words), std::move(needs), run.model());
    training.uses.gpus = several_cards() ? 1 : 0;
    return training;
  }

  /// The plan is made for one request, and so is all that follows from it.
  Job job(const std::string& name, std::vector<std::string> words, std::vector<std::string> needs,
          const fs::path& product) const {
    words.insert(words.end(), {"--threads", fmt::format("{}", threads()), "--json"});
    Job job;
    job.name = name;
    job.words = std::move(words);
    job.needs = std::move(needs);
    job.inputs = key_of(plan_.request);
    job.product = product.lexically_relative(folder_.root).string();
    job.uses.threads = threads();
    return job;
  }

  /// The static set has half of what the clip may have; share_limits has the windows' part.
  TrainArguments half_limits() const {
    TrainArguments arguments = request_.arguments;
    const TrainOptions& options = planned_.options;
    if (options.max_gaussians > 0)
      arguments.given["max_gaussians"] =
          fmt::format("{}", std::max<int64_t>(options.max_gaussians / 2, 1));
    if (options.max_bytes > 0)
      arguments.given["max_bytes"] = fmt::format("{}", options.max_bytes / 2);
    return arguments;
  }

  bool several_cards() const { return request_.gpus > 1; }
  /// Of one job.
  int64_t threads() const {
    const int64_t cores = std::max(1u, std::thread::hardware_concurrency());
    return request_.arguments.threads > 0 ? request_.arguments.threads
                                          : std::max<int64_t>(1, cores / request_.gpus);
  }

  JobSlots slots() const {
    JobSlots slots{{}, threads() * request_.gpus, 0};
    slots.gpus.resize(size_t(request_.gpus));
    std::iota(slots.gpus.begin(), slots.gpus.end(), 0);
    return slots;
  }

  JobsObserver observer() {
    JobsObserver observer;
    observer.on_start = [this](const Job& job, int64_t, int64_t) {
      say(fmt::format("{}: {}", title(job.name), jobs_.log(job.name).string()));
    };
    observer.on_end = [this](const Job& job, const JobOutcome& outcome) {
      ++ended_;
      if (outcome.exit_code == 0)
        ++done_, tell(job.name, read_record(jobs_, job.name)["result"]);
      else if (!interrupted() && !is_over())
        warn(fmt::format("{}: {}", title(job.name), without_name(outcome.message)));
      forget_checkpoints();
    };
    observer.on_look = [this](const std::vector<std::string>& running) {
      if (!bar_) bar_.emplace("windows");
      bar_->update(ended_, request_.count + 2, last_line(jobs_.log(running.front())));
    };
    observer.signal = [this] { return is_over() && !interrupted() ? SIGTERM : stop_signal(); };
    return observer;
  }

  /// "window 3 of 12".
  std::string title(const std::string& job) const {
    for (int64_t i = 0; i < request_.count; ++i)
      if (job == window_job(i)) return fmt::format("window {} of {}", i + 1, request_.count);
    return job == kScene ? "what stands still" : "static Gaussians";
  }

  void tell(const std::string& job, const json& result) const {
    if (job != kScene) return say(fmt::format("{}: {}", title(job), training_text(result)));
    for (const json& warning : result["warnings"]) warn(warning.get<std::string>());
    say(fmt::format("static: {:.0f} % of the pixels of {} cameras look the same all along",
                    100 * result["shared"].get<double>(), result["frames"].get<int64_t>()));
  }

  /// Trainings that run have time to save then.
  bool is_over() const {
    const double limit = request_.time_limit;
    return limit > 0 && request_.stopwatch() > limit - std::clamp(0.1 * limit, 0.5, 5.0);
  }

  [[noreturn]] void refuse(const JobsOutcome& outcome) const {
    const json record = read_record(jobs_, outcome.failed.front());
    std::vector<std::string> lost = outcome.failed;
    lost.insert(lost.end(), outcome.skipped.begin(), outcome.skipped.end());
    std::erase_if(lost, [](const std::string& job) { return job == kScene || job == kStatic; });
    const std::string text = fmt::format(
        "{} of {} windows are not trained. {}: {}; repeat the command when that is fixed",
        lost.size(), request_.count, title(outcome.failed.front()),
        without_name(record.value("message", "")));
    if (record.value("exit_code", 0) == kExitBadInput) throw InputError(text);
    throw std::runtime_error(text);
  }

  const WindowsRequest& request_;
  const WindowsFolder folder_;
  const JobFolder jobs_;
  const PlannedOptions planned_;
  bool continues_ = false;  // what an earlier program has trained
  TrainingTerminal terminal_;
  WindowsPlan plan_;
  std::optional<ProgressBar> bar_;
  int64_t ended_ = 0, done_ = 0;  // jobs
  const fs::file_time_type begin_ = fs::file_time_type::clock::now();
};

}  // namespace

json train_windows(const WindowsRequest& request) {
  return WindowsTraining(request).run();
}

}  // namespace tessera
