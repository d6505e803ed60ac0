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

class WindowsTraining {
 public:
  explicit WindowsTraining(const WindowsRequest& request)
      : request_(request), folder_{request.root} {}

  json run() {
    request_json_ = asked_of_windows();
    make_room();
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
  json asked_of_windows() {
    json asked =
        asked_of_training(request_.arguments, resolve_options(request_.arguments, request_.scene));
    asked[kSceneFiles] = files_of_scene();
    asked[kWindows] = request_.count;
    return asked;
  }

  /// What is there of another request is refused, or kept as ROOT.1 where that is asked for.
  void make_room() {
    const RunRecord record = record_of(RunFolder{folder_.root}, request_.scene);
    if (action_in(folder_.root, record, request_json_, request_.overwrite) == RunAction::kReplace)
      RunLock(folder_.root, terminal_).make_room();
    continues_ = WindowsFolder::is_finished(folder_.static_run());
  }

  /// The plan, what stands still and its training. False: it was stopped.
  bool prepare() {
    bool is_told = false;
    while (true) {
      if (folder_.exists()) {
        plan_ = folder_.read();
        if (WindowsFolder::is_finished(folder_.static_run())) break;
      }
      if (!is_run_locked(folder_.root)) {
        try {
          const RunLock lock(folder_.root, terminal_);
          if (folder_.exists())  // another program may have made it since
            plan_ = folder_.read();
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

  /// The plan names the scene where it was found last: it may have been moved.
  void follow_scene() {
    const std::string scene = fs::absolute(request_.scene).string();
    if (plan_.scene == scene || is_run_locked(folder_.root)) return;
    const RunLock lock(folder_.root, terminal_);
    plan_.scene = scene;
    folder_.write(plan_);
  }

  void make_plan() {
    const RunFolder whole{folder_.root};
    whole.require_room();
    whole.remove_files();  // of a training that was only begun
    if (!request_.reason.empty()) say(request_.reason);
    const Scene scene = scene_without_pixels(request_.scene, false);
    plan_.scene = fs::absolute(request_.scene).string();
    plan_.clip = scene.time_axis;
    plan_.windows = cut_clip(scene, request_.count, plan_.overlap);
    plan_.scene_files = files_of_scene();
    plan_.request = request_json_;
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
    return training;
  }

  /// Starts, resumes or leaves the training as it is. False when it was stopped.
  bool trained(const std::string& name, TrainRequest& training) {
    const RunFolder run{training.run};
    const RunAction action =
        action_in(run.root, record_of(run, training.scene), json::parse(training.made_for), false);
    if (action != RunAction::kDone) {
      training.resume = action == RunAction::kResume;
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
  bool continues_ = false;  // what an earlier program has trained
  TrainingTerminal terminal_;
  WindowsPlan plan_;
  std::string scene_files_;
  json request_json_;
  std::set<int64_t> checked_;              // finished windows of this request
  std::map<int64_t, std::string> failed_;  // why
};

}  // namespace

json train_windows(const WindowsRequest& request) {
  return WindowsTraining(request).run();
}

}  // namespace tessera
