// `tessera train`: options from preset, ablation, --config and command line, in that order.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/options/presets.h"
#include "tools/batch/engine.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/output_place.h"
#include "tools/cli/run_record.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/terminal.h"
#include "tools/cli/train_arguments.h"
#include "tools/cli/training_terminal.h"
#include "tools/export/formats.h"
#include "tools/export/player_files.h"
#include "tools/export/run_successor.h"
#include "tools/live/earlier_training.h"
#include "tools/live/live_training.h"
#include "tools/live/stopped_training.h"
#include "tools/live/view_child.h"
#include "tools/session/clock/time_limit.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"
#include "tools/session/train_start.h"
#include "tools/session/windows_folder.h"
#include "tools/view/view_server.h"
#include "tools/windows/train_windows.h"
#include "tools/windows/window_choice.h"
#include "tools/windows/window_workers.h"
#include "tools/windows/windows_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::string steps_text(const nlohmann::json& result) {
  return fmt::format("stopped after {} of {} steps", result["iterations"].get<int64_t>(),
                     result["total_iterations"].get<int64_t>());
}

/// The last line of a training that left before its end; "" for one that has ended. `place`: the
/// run folder that was named, which differs from that of the request for a successor.
std::string stopped_text(const TrainRequest& request, const fs::path& place,
                         const nlohmann::json& result) {
  if (result["finished"].get<bool>()) return "";
  const std::string how =
      request.run == place
          ? fmt::format("resume with: tessera train {} -o {} --resume", request.scene.string(),
                        place.string())
          : fmt::format(
                "{} keeps its earlier result; repeat the command with --overwrite to resume",
                place.string());
  return fmt::format("\n{}; {}", steps_text(result), how);
}

/// Completes a move of a successor that was cut off.
void complete_move(const fs::path& place, TrainingTerminal& terminal) {
  if (!fs::exists(place / kNext)) return;
  const RunLock lock(place, terminal);
  finish_training_move(place);
}

/// Where --overwrite would replace a model: the request becomes that of its successor in RUN/next,
/// which resumes what is there of the same options.
void train_beside(TrainRequest& request) {
  request.run /= kNext;
  WindowsFolder{request.run}.remove();
  request.resume = can_resume(request, RunFolder{request.run});
}

/// A complete successor takes its place, and the results name it there.
void take_place(const TrainRequest& request, const fs::path& place, nlohmann::json& result) {
  move_training(request.run, place);
  result["model"] = RunFolder{place}.model().string();
  if (!result["exposure"].is_null())
    result["exposure"]["file"] = RunFolder{place}.exposure().string();
}

/// A training whose page may stop and resume it, with its view.
class ViewedTraining {
 public:
  /// `place`: the run folder that was named; that of `request` differs for a successor.
  /// `restarts`: a refused checkpoint is renamed, and the training begins again.
  ViewedTraining(TrainRequest request, fs::path place, bool restarts, bool with_view,
                 TrainingTerminal& terminal)
      : request_(std::move(request)),
        place_(std::move(place)),
        restarts_(restarts),
        with_view_(with_view),
        terminal_(terminal) {}

  /// Until the end, or until it is left and nobody resumes it.
  nlohmann::json train() {
    nlohmann::json result = train_once();
    while (!result["finished"].get<bool>() && view_ && (by_page_ || is_at_terminal()) &&
           view_->serve_until_resumed(steps_text(result))) {
      request_.resume = true;
      request_.stop_after.reset();
      request_.more_iterations.reset();
      request_.time_limit = 0;
      result = train_once();
    }
    return result;
  }
  const TrainRequest& request() const { return request_; }
  /// Of the last training: a signal that ends the view after it does not count.
  int exit_code() const { return exit_code_; }
  void serve() const {
    if (view_) view_->serve();
  }

 private:
  bool succeeds() const { return request_.run != place_; }

  nlohmann::json train_once() {
    std::optional<RunLock> lock;  // a training without a successor takes it itself
    if (succeeds()) lock.emplace(place_, terminal_);
    LiveTraining live(terminal_, request_.run, [&] {
      if (with_view_ && !view_) view_ = std::make_unique<ViewChild>(place_, by_hand());
    });
    request_.snapshots = &live;
    nlohmann::json result =
        succeeds() || restarts_ ? train_or_restart(request_, live) : train_session(request_, live);
    by_page_ = live.stopped();
    exit_code_ = interrupted()                ? stop_code()
                 : result["left"].get<bool>() ? kExitNotFinished
                                              : kExitDone;
    if (succeeds() && result["finished"].get<bool>()) take_place(request_, place_, result);
    return result;
  }

  std::string by_hand() const {
    return succeeds() ? repeated_command()
                      : shell_line({"tessera", "train", request_.scene.string(), "-o",
                                    place_.string(), "--resume"});
  }

  TrainRequest request_;
  const fs::path place_;
  const bool restarts_, with_view_;
  TrainingTerminal& terminal_;
  std::unique_ptr<ViewChild> view_;
  bool by_page_ = false;  // the last training was stopped by its page
  int exit_code_ = kExitDone;
};

/// --resume=auto: what is done where `place` holds an earlier run. False: nothing is left to do.
bool plan_training(TrainRequest& request, const fs::path& place, TrainingTerminal& terminal) {
  const RunFolder run{place};
  const RunPlan plan = plan_run(record_of(run, request.scene),
                                nlohmann::json::parse(request.made_for), request.overwrite);
  request.resume = plan.action == RunAction::kResume;
  if (plan.action == RunAction::kDone) return false;
  if (plan.action == RunAction::kRefuse) throw finished_run_error(place, plan.changed);
  if (plan.action == RunAction::kReplace) return true;
  request.overwrite = true;  // no finished run is there
  if (request.resume || !fs::exists(run.checkpoint())) return true;
  const RunLock lock(place, terminal);  // not that of a training that runs
  const fs::path aside = run.set_checkpoint_aside();
  warn(text_of_aside(run.checkpoint(), plan.changed, aside));
  return true;
}

struct Parsed {
  TrainRequest request;
  TrainArguments arguments;
  bool json = false, view = false;
  std::string resume, window, windows = "none", time_limit;
  int64_t stop_after = 0, gpus = 1;
};

/// --windows of more than one: the exit code; nothing where the clip is trained as a whole.
std::optional<int> train_in_windows(const Parsed& parsed) {
  const TrainRequest& request = parsed.request;
  if (parsed.windows == "none") return std::nullopt;
  const Motion motion =
      resolve_options(parsed.arguments, request.scene, request.window).options.motion;
  const WindowChoice choice = choose_windows(parsed.windows, request.scene, motion);
  if (choice.count <= 1) {
    if (!choice.reason.empty()) say(choice.reason);
    return std::nullopt;
  }
  for (const auto& [given, name] : {std::pair{!parsed.window.empty(), "--window"},
                                    {!request.static_model.empty(), "--static-model"},
                                    {parsed.resume == "true", "--resume"},
                                    {parsed.view, "--view"},
                                    {parsed.stop_after > 0, "--stop-after"}})
    if (given)
      throw InputError(fmt::format(
          "--windows: {} is of one training; leave it out (the same command resumes)", name));
  WindowsRequest windows;
  windows.scene = request.scene;
  windows.root = request.run;
  windows.arguments = parsed.arguments;
  windows.count = choice.count;
  windows.reason = choice.reason;
  windows.gpus = parsed.gpus;
  windows.overwrite = request.overwrite;
  windows.time_limit = request.time_limit;
  windows.stopwatch = request.stopwatch;
  const nlohmann::json result = train_windows(windows);
  print_result(parsed.json, result, windows_text(result));
  return interrupted() ? stop_code() : result["left"].get<bool>() ? kExitNotFinished : kExitDone;
}

/// The exit code. `decides`: --resume=auto.
int train_and_report(TrainRequest request, bool decides, bool as_json, bool with_view) {
  try {
    TrainingTerminal terminal;
    const fs::path place = request.run;
    complete_move(place, terminal);
    const bool in_windows = WindowsFolder{place}.exists();
    if (in_windows && !request.overwrite)
      throw InputError(
          fmt::format("{}: holds a clip in windows; take another -o, or replace it by --overwrite",
                      place.string()));
    if (decides && !plan_training(request, place, terminal)) {
      const nlohmann::json result = recorded_result(RunFolder{place});
      print_result(as_json, result, training_text(result) + "\ndone before, unchanged");
      return kExitDone;
    }
    const bool holds_model = in_windows || fs::exists(RunFolder{place}.model());
    if (request.overwrite && !request.resume && holds_model) train_beside(request);
    ViewedTraining training(std::move(request), place, decides, with_view, terminal);
    const nlohmann::json result = training.train();
    print_result(as_json, result,
                 training_text(result) + stopped_text(training.request(), place, result));
    if (result["finished"].get<bool>()) training.serve();
    return training.exit_code();
  } catch (const CheckpointRefused& error) {
    report_error(fmt::format("tessera: {}", error.what()));
    return kExitCheckpointRefused;
  }
}

}  // namespace

void add_train_command(CLI::App& app, Work& work) {
  const auto parsed = std::make_shared<Parsed>();
  CLI::App& command =
      *app.add_subcommand("train", "train a model from a prepared scene or a D-NeRF folder");
  command.add_option("scene", parsed->request.scene, "prepared scene or D-NeRF folder")->required();
  command.add_option("-o,--out", parsed->request.run, "run folder")->required();
  command
      .add_flag("--resume", parsed->resume,
                "resume from the checkpoint; =auto: start, resume or leave as it is")
      ->check(CLI::IsMember({"auto", "true"}));
  command.add_flag("--overwrite", parsed->request.overwrite,
                   "replace the run that is there once the new one is complete");
  command.add_option("--stop-after", parsed->stop_after,
                     "steps of this call; training then stops with a checkpoint; 0: all");
  command.add_option("--time-limit", parsed->time_limit,
                     "stop with a checkpoint and exit code 75 before this time: 1h30m");
  command.add_option("--window", parsed->window,
                     "I/N: the I-th of N equal parts of the clip alone");
  command
      .add_option("--windows", parsed->windows,
                  "auto, none, or a length: the whole clip in windows, 5s")
      ->capture_default_str();
  add_gpus_option(command, parsed->gpus);
  command.add_option("--static-model", parsed->request.static_model,
                     "run folder whose static Gaussians all windows share");
  command.add_flag("--view", parsed->view, "show the training in a browser: tessera view RUN");
  command.add_flag("--json", parsed->json, "print one JSON object");
  add_train_options(command, parsed->arguments);
  command.callback([parsed, &work] {
    work = [parsed] {
      if (parsed->view) require_view_server();
      TrainRequest& request = parsed->request;
      const bool decides = parsed->resume == "auto";
      request.resume = !decides && !parsed->resume.empty();
      request.stopwatch = running_stopwatch();
      if (!parsed->time_limit.empty()) request.time_limit = parse_duration(parsed->time_limit);
      if (!parsed->window.empty()) request.window = window_of_text(parsed->window, "--window");
      const TrainArguments& arguments = parsed->arguments;
      set_thread_count(arguments.threads);
      check_output_apart(request.run, request.scene);
      if (const std::optional<int> done = train_in_windows(*parsed)) return *done;
      PlannedOptions planned = resolve_options(arguments, request.scene, request.window);
      if (request.resume) {
        const RunFolder run{request.run};
        if (request.window && request.window != run.window())
          throw InputError(fmt::format(
              "--window {}: the run was begun {}; leave the option out, or start a new run folder",
              parsed->window,
              run.window() ? "with window " + text_of(*run.window()) : "with the whole scene"));
        request.window = run.window();
        request.static_model = run.static_model();
      }
      take_arguments(arguments, std::move(planned), key_of(file_stamps(request.scene)), request);
      if (request.resume) request.made_for = RunFolder{request.run}.made_for();
      if (parsed->stop_after > 0) request.stop_after = parsed->stop_after;
      const bool more_steps =
          arguments.given.size() == 1 && arguments.given.count("iterations") > 0;
      if (request.resume && more_steps) request.more_iterations = request.options.iterations;
      // without a checkpoint the session refuses, which is the better advice
      if (request.resume && std::filesystem::exists(RunFolder{request.run}.checkpoint()) &&
          ((!arguments.given.empty() && !more_steps) || !arguments.config.empty() ||
           !arguments.ablation.empty()))
        throw InputError(
            "--resume goes on with the options of the checkpoint; of them --iterations alone may "
            "be given; drop the others or start a new run folder");
      if (!request.resume) check_max_bytes(request.scene.string(), request.options.max_bytes);
      if (const std::string note = page_bytes_note(request.options.max_bytes); !note.empty())
        say(note);
      return train_and_report(request, decides, parsed->json, parsed->view);
    };
  });
}

}  // namespace tessera
