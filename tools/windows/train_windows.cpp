// What all windows share is made under the lock of the folder, each window under that of its run.
#include "tools/windows/train_windows.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "ingest/derived/static_scene.h"
#include "ingest/files/atomic_file.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/run_record.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/training_terminal.h"
#include "tools/export/run_successor.h"
#include "tools/live/earlier_training.h"
#include "tools/live/stopped_training.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"
#include "tools/windows/window_workers.h"
#include "tools/windows/windows_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::chrono::seconds kBetweenLooks{1};
constexpr const char* kTwoWays = "take another -o, or replace it by --overwrite";

class WindowsTraining {
 public:
  explicit WindowsTraining(const WindowsRequest& request)
      : request_(request),
        folder_{request.root},
        continues_(WindowsFolder::is_finished(folder_.static_run())) {}

  /// --overwrite: whether finished trainings of another clip, cut or request would be lost.
  bool replaces_results() {
    if (fs::exists(RunFolder{folder_.root}.model())) return true;
    if (!folder_.exists() || is_of_this_request()) return false;
    for (int64_t i = 0; i < int64_t(plan_.windows.size()); ++i)
      if (WindowsFolder::is_finished(folder_.window_run(i))) return true;
    return false;
  }

  json run() {
    if (!prepare()) return result(true);
    follow_scene();
    const WindowWorkers workers(worker_words(), request_.gpus - 1, folder_.root);
    const bool left = !train_all();
    for (const std::string& failure : workers.failures()) warn(failure);
    json all = result(left);
    if (!left && !failed_.empty())
      throw InputError(fmt::format(
          "{} of {} windows could not be trained; the others are. Window {}: {}; repeat the "
          "command when that is fixed",
          failed_.size(), plan_.windows.size(), failed_.begin()->first + 1,
          failed_.begin()->second));
    return all;
  }

 private:
  /// The plan, what stands still and its training. False: it was stopped.
  bool prepare() {
    bool is_told = false;
    while (true) {
      const bool may_differ = request_.overwrite && !is_run_locked(folder_.root);
      if (folder_.exists() && !may_differ) {
        check_plan();
        if (WindowsFolder::is_finished(folder_.static_run())) break;
      }
      if (!is_run_locked(folder_.root)) {
        try {
          const RunLock lock(folder_.root, terminal_);
          if (request_.overwrite) remove_others();
          if (folder_.exists())
            check_plan();  // another program may have made it since
          else
            make_plan();
          return make_static();
        } catch (const InputError&) {
          if (!is_run_locked(folder_.root)) throw;  // another program was faster
        }
      }
      if (!is_told) say("another program prepares what the windows share; waits for it");
      is_told = true;
      if (!waited()) return false;
    }
    return make_static();  // done before, of the same request
  }

  /// --overwrite: windows of another clip, cut or request go.
  void remove_others() {
    if (folder_.exists() && !is_of_this_request()) {
      folder_.remove();
      plan_ = {};
    }
  }

  bool is_of_this_request() {
    if (!has_plan_of_request()) return false;
    const fs::path scene = folder_.static_scene();
    if (!is_prepared_scene(scene)) return true;  // nothing is trained yet
    const TrainRequest training =
        request_of(scene, folder_.static_run(), {}, key_of(file_stamps(scene)));
    return plan_of(training).action != RunAction::kRefuse;
  }

  /// A training of the whole clip in this folder: a finished one is refused without --overwrite.
  void give_way() const {
    const RunFolder whole{folder_.root};
    if (!whole.exists()) return;
    if (fs::exists(whole.model()) && !request_.overwrite)
      throw InputError(fmt::format("{}: holds a training of the whole clip; {}",
                                   folder_.root.string(), kTwoWays));
    if (!fs::exists(whole.model()) && fs::exists(whole.checkpoint()))
      say(fmt::format("the checkpoint of the whole clip is now {}",
                      whole.set_checkpoint_aside().string()));
    whole.remove_files();
  }

  static RunPlan plan_of(const TrainRequest& training) {
    return plan_run(record_of(RunFolder{training.run}, training.scene),
                    json::parse(training.made_for), false);
  }

  /// The command of a program that trains windows of this folder, too.
  std::vector<std::string> worker_words() const {
    const double length = plan_.clip.duration / double(request_.count);
    std::vector<std::string> words{"train",     request_.scene.string(),
                                   "-o",        folder_.root.string(),
                                   "--windows", fmt::format("{:.9f}s", length)};
    const std::vector<std::string> of_training = words_of(request_.arguments);
    words.insert(words.end(), of_training.begin(), of_training.end());
    return words;
  }

  /// False when it was stopped.
  bool waited() {
    std::this_thread::sleep_for(kBetweenLooks);
    return !terminal_.must_stop();
  }

  /// Reads the plan. False: it is of another clip or cut.
  bool has_plan_of_request() {
    plan_ = folder_.read();
    return int64_t(plan_.windows.size()) == request_.count && plan_.scene_files == files_of_scene();
  }

  void check_plan() {
    if (has_plan_of_request()) return;
    const auto count = int64_t(plan_.windows.size());
    throw InputError(fmt::format(
        "{}: holds {} windows of {}{}; {}", folder_.root.string(), count,
        count == request_.count ? request_.scene.string() : plan_.scene,
        count == request_.count ? " as it was, whose files have changed" : "", kTwoWays));
  }

  /// The plan names the scene where it was found last: it may have been moved.
  void follow_scene() {
    const std::string scene = fs::absolute(request_.scene).string();
    if (plan_.scene == scene || is_run_locked(folder_.root)) return;
    const RunLock lock(folder_.root, terminal_);
    plan_.scene = scene;
    folder_.write(plan_);
  }

  void make_plan() {
    give_way();
    if (!request_.reason.empty()) say(request_.reason);
    const Scene scene = scene_without_pixels(request_.scene, false);
    plan_.scene = fs::absolute(request_.scene).string();
    plan_.clip = scene.time_axis;
    plan_.windows = cut_clip(scene, request_.count, plan_.overlap);
    plan_.scene_files = files_of_scene();
    folder_.write(plan_);
  }

  const std::string& files_of_scene() {
    if (scene_files_.empty()) scene_files_ = key_of(file_stamps(request_.scene));
    return scene_files_;
  }

  bool make_static() {
    const fs::path scene = folder_.static_scene();
    if (!is_prepared_scene(scene)) {
      ProgressBar bar("static");
      const StaticSceneReport report =
          write_static_scene(request_.scene, scene, [&](int64_t done, int64_t total) {
            stop_if_interrupted();
            bar.update(done, total, "cameras");
          });
      bar.clear();
      for (const std::string& warning : report.warnings) warn(warning);
      say(fmt::format("static: {:.0f} % of the pixels of {} cameras look the same all along",
                      100 * report.shared, report.cameras));
    }
    TrainRequest training = request_of(scene, folder_.static_run(), {}, key_of(file_stamps(scene)));
    return trained("static", training);
  }

  TrainRequest request_of(const fs::path& scene, const fs::path& run,
                          const std::optional<Window>& window, const std::string& files) {
    TrainRequest training;
    training.scene = scene;
    training.run = run;
    training.window = window;
    if (window) training.static_model = folder_.static_run();
    take_arguments(request_.arguments, resolve_options(request_.arguments, scene, window), files,
                   training);
    training.time_limit = request_.time_limit;
    training.stopwatch = request_.stopwatch;
    training.overwrite = true;  // of a run that has not ended
    return training;
  }

  /// Starts, resumes or leaves the training as it is. False when it was stopped.
  bool trained(const std::string& name, TrainRequest& training) {
    const RunFolder run{training.run};
    const RunPlan plan = plan_of(training);
    if (plan.action == RunAction::kRefuse)
      throw InputError(fmt::format("{}: is trained with another request: {}; {}", run.root.string(),
                                   text_of_changes(plan.changed), kTwoWays));
    if (plan.action != RunAction::kDone) {
      training.resume = plan.action == RunAction::kResume;
      say(fmt::format("{}: {}", name, training.resume ? "is resumed" : "training"));
      TrainingTerminal terminal;
      const json result = train_or_restart(training, terminal);
      if (!result["finished"].get<bool>()) return false;
      say(training_text(result));
    }
    std::error_code ignored;
    fs::remove(run.checkpoint(), ignored);
    return true;
  }

  /// False when it was stopped.
  bool train_all() {
    while (true) {
      bool is_with_others = false;
      for (int64_t i = 0; i < int64_t(plan_.windows.size()); ++i) {
        if (!folder_.exists()) return true;  // another program was done, and has moved it
        if (failed_.contains(i)) continue;
        const fs::path run = folder_.window_run(i);
        if (is_run_locked(run)) {
          is_with_others = true;
          continue;
        }
        if (checked_.contains(i) && WindowsFolder::is_finished(run)) continue;
        try {
          TrainRequest training =
              request_of(request_.scene, run, plan_.window(i), files_of_scene());
          if (!trained(fmt::format("window {} of {}", i + 1, plan_.windows.size()), training))
            return false;
          checked_.insert(i);
        } catch (const std::runtime_error& error) {
          if (terminal_.must_stop()) throw;
          if (is_run_locked(run))
            is_with_others = true;  // another program was faster
          else
            fail(i, error);
        }
      }
      if (!is_with_others) return true;
      if (!waited()) return false;
    }
  }

  /// What concerns all windows ends the work; what concerns one is told at the end.
  void fail(int64_t index, const std::runtime_error& error) {
    if (dynamic_cast<const WriteError*>(&error) != nullptr ||
        dynamic_cast<const DeviceError*>(&error) != nullptr)
      throw;
    failed_[index] = error.what();
    warn(fmt::format("window {} of {}: {}", index + 1, plan_.windows.size(), error.what()));
  }

  json result(bool left) const {
    json all = windows_result(folder_);
    all["windows"] = request_.count;  // also before the clip is cut
    all["finished"] = all["finished"].get<bool>() && !left;
    all["left"] = left;
    all["continued"] = continues_;
    return all;
  }

  const WindowsRequest& request_;
  const WindowsFolder folder_;
  const bool continues_;  // what an earlier program has trained
  TrainingTerminal terminal_;
  WindowsPlan plan_;
  std::string scene_files_;
  std::set<int64_t> checked_;              // finished windows of this request
  std::map<int64_t, std::string> failed_;  // why
};

/// The complete windows in OUT/next move to OUT, by this program or another.
void take_place(const fs::path& root) {
  TrainingTerminal terminal;
  while (is_run_locked(root)) std::this_thread::sleep_for(kBetweenLooks);
  const RunLock lock(root, terminal);
  if (WindowsFolder{root / kNext}.exists()) move_training(root / kNext, root);
}

/// Completes a move that was cut off.
void complete_move(const fs::path& root) {
  if (!fs::exists(root / kNext) || is_run_locked(root)) return;
  TrainingTerminal terminal;
  const RunLock lock(root, terminal);
  finish_training_move(root);
}

}  // namespace

json train_windows(const WindowsRequest& request) {
  const fs::path next = request.root / kNext;
  complete_move(request.root);
  WindowsTraining in_place(request);
  if (!request.overwrite || !in_place.replaces_results()) return in_place.run();
  WindowsRequest beside = request;
  beside.root = next;
  json made = WindowsTraining(beside).run();
  if (WindowsFolder{next}.exists() && !made["finished"].get<bool>()) return made;
  take_place(request.root);
  json result = windows_result(WindowsFolder{request.root});
  for (const char* kept : {"left", "continued"}) result[kept] = made[kept];
  return result;
}

}  // namespace tessera
