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
#include "tools/cli/backend_options.h"
#include "tools/cli/background_program.h"
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
#include "tools/live/earlier_training.h"
#include "tools/live/live_training.h"
#include "tools/live/stopped_training.h"
#include "tools/live/view_child.h"
#include "tools/session/clock/time_limit.h"
#include "tools/session/locks.h"
#include "tools/session/model_scene.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"
#include "tools/view/view_server.h"
#include "tools/windows/cut_for_run.h"
#include "tools/windows/train_windows.h"
#include "tools/windows/windows_result.h"

namespace tessera {
namespace {

std::string resumed_by(const TrainRequest& request) {
  return shell_line(
      {"tessera", "train", request.scene.string(), "-o", request.run.string(), "--resume"});
}

/// The last line of a training that left before its end; "" for one that has ended.
std::string stopped_text(const TrainRequest& request, const nlohmann::json& result) {
  if (result["finished"].get<bool>()) return "";
  return fmt::format("\nstopped after {} of {} steps; resume with: {}",
                     result["iterations"].get<int64_t>(), result["total_iterations"].get<int64_t>(),
                     resumed_by(request));
}

struct Parsed {
  TrainRequest request;
  TrainArguments arguments;
  bool json = false, overwrite = false;
  ViewOptions view;
  std::string resume, window, windows = "none", time_limit;
  int64_t stop_after = 0, gpus = 1;
};

/// --windows of more than one: the exit code; nothing where the clip is trained as a whole.
std::optional<int> train_in_windows(const Parsed& parsed, const std::string& files) {
  const TrainRequest& request = parsed.request;
  check_gpus(parsed.gpus, parsed.arguments.backend);
  if (parsed.windows == "none") return std::nullopt;
  const TrainOptions options = resolve_options(parsed.arguments, request.scene).options;
  const WindowChoice choice =
      cut_for_run(parsed.windows, request.scene, files, options.motion, request.run, parsed.gpus);
  if (choice.count <= 1) {
    if (!choice.reason.empty()) say(choice.reason);
    return std::nullopt;
  }
  check_max_bytes(request.scene.string(), options.max_bytes);
  for (const auto& [given, name] : {std::pair{!parsed.window.empty(), "--window"},
                                    {!request.static_model.empty(), "--static-model"},
                                    {parsed.resume == "true", "--resume"},
                                    {parsed.view.view, "--view"},
                                    {parsed.stop_after > 0, "--stop-after"}})
    if (given)
      throw InputError(fmt::format(
          "--windows: {} is of one training; leave it out (the same command resumes)", name));
  WindowsRequest windows;
  windows.scene = request.scene;
  windows.root = request.run;
  windows.arguments = parsed.arguments;
  windows.files = files;
  windows.count = choice.count;
  windows.reason = choice.reason;
  windows.gpus = parsed.gpus;
  windows.overwrite = parsed.overwrite;
  windows.time_limit = request.time_limit;
  windows.stopwatch = request.stopwatch;
  const nlohmann::json result = train_windows(windows);
  print_result(parsed.json, result, windows_text(result));
  return interrupted() ? stop_code() : result["left"].get<bool>() ? kExitNotFinished : kExitDone;
}

/// The exit code. Without --resume the folder decides: what is of this request is resumed or done.
int train_and_report(TrainRequest request, const Parsed& parsed) {
  try {
    TrainingTerminal terminal;
    const RunFolder run{request.run};
    const bool decides = !request.resume;
    if (decides) {
      const RunAction action = action_in(request.run, record_of(run, request.scene),
                                         nlohmann::json::parse(request.made_for), parsed.overwrite);
      if (action == RunAction::kDone) {
        nlohmann::json result = recorded_result(run);
        result["done_before"] = true;
        print_result(parsed.json, result, training_text(result) + "\ndone before, unchanged");
        return kExitDone;
      }
      if (action == RunAction::kReplace) RunLock(request.run, terminal).make_room();
      request.resume = action == RunAction::kResume;
    }
    std::unique_ptr<ViewChild> view;
    LiveTraining live(terminal, request.run, [&] {
      if (parsed.view.view)
        view = std::make_unique<ViewChild>(request.run, resumed_by(request), parsed.view);
    });
    request.snapshots = &live;
    const nlohmann::json result =
        decides ? train_or_restart(request, live) : train_session(request, live);
    const int code = interrupted()                ? stop_code()
                     : result["left"].get<bool>() ? kExitNotFinished
                                                  : kExitDone;
    print_result(parsed.json, result, training_text(result) + stopped_text(request, result));
    if (view) view->serve(result["finished"].get<bool>() ? "the result" : "where it has stopped");
    return code;
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
  command.add_flag("--resume", parsed->resume, "resume with the options of the checkpoint")
      ->check(CLI::IsMember({"auto", "true"}));
  command.add_flag("--overwrite", parsed->overwrite,
                   "what is there of another request becomes RUN.1; the training starts anew");
  command.add_option("--stop-after", parsed->stop_after,
                     "steps of this call; training then stops with a checkpoint; 0: all");
  command.add_option("--time-limit", parsed->time_limit,
                     "stop with a checkpoint and exit code 75 before this time: 1h30m");
  command.add_option("--window", parsed->window,
                     "I/N: the I-th of N equal parts of the clip alone");
  command
      .add_option("--windows", parsed->windows,
                  "auto, none, or a length, 5s; auto:5s: where it can be cut")
      ->capture_default_str();
  add_gpus_option(command, parsed->gpus);
  command.add_option("--static-model", parsed->request.static_model,
                     "run folder whose static Gaussians all windows share");
  add_view_options(command, parsed->view);
  command.add_flag("--json", parsed->json, "print one JSON object");
  add_train_options(command, parsed->arguments);
  command.callback([parsed, &work] {
    work = [parsed] {
      if (parsed->view.view) require_view_server();
      TrainRequest& request = parsed->request;
      request.resume = parsed->resume == "true";
      request.stopwatch = running_stopwatch();
      if (!parsed->time_limit.empty()) request.time_limit = parse_duration(parsed->time_limit);
      if (!parsed->window.empty()) request.window = window_of_text(parsed->window, "--window");
      const TrainArguments& arguments = parsed->arguments;
      set_thread_count(arguments.threads);
      refuse_trained(request.scene, "scene");
      check_output_apart(request.run, request.scene);
      const std::string files = key_of(file_stamps(request.scene));
      if (const std::optional<int> done = train_in_windows(*parsed, files)) return *done;
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
      take_arguments(arguments, std::move(planned), files, request);
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
      return train_and_report(request, *parsed);
    };
  });
}

}  // namespace tessera
