// Runs the stages in order. The inputs of each stage contain those of the stage before it, so that
// a change reruns all later stages.
#include "tools/run/run_stages.h"

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/camera_table_text.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "ingest/ingest.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/seconds_since.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/run_record.h"
#include "tools/cli/training_terminal.h"
#include "tools/clip/clip_scores.h"
#include "tools/export/formats.h"
#include "tools/export/player_files.h"
#include "tools/export/run_outputs.h"
#include "tools/live/earlier_training.h"
#include "tools/live/live_training.h"
#include "tools/live/stopped_training.h"
#include "tools/live/view_child.h"
#include "tools/report/write_run_report.h"
#include "tools/run/run_stage.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/locks.h"
#include "tools/session/output_folder.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"
#include "tools/web/web_page.h"
#include "tools/windows/cut_for_run.h"
#include "tools/windows/train_windows.h"
#include "tools/windows/windows_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

IngestOptions defaults_for(const IngestOptions& options) {
  IngestOptions defaults;
  defaults.allow_static = options.allow_static;
  if (options.frames_as == FramesAs::kAuto) defaults.frames_as = FramesAs::kAuto;
  return defaults;
}

constexpr RunStage kIngest{1, "ingest", "ingest", false, true},
    kTrain{2, "train", "train", true, true}, kEvaluate{3, "evaluate", "evaluate"},
    kExport{4, "export", "export"}, kPage{5, "page", "player"}, kReport{6, "report", "report"};

constexpr const char* kCaptureFiles = "contents of the capture";  // 0.3: "files of"
constexpr const char* kAsked = "asked";  // the entry of the request, which is done with the run

/// What a run is asked for, but for what is made anew in seconds.
json asked_of(const RunRequest& request) {
  json asked = to_json(resolve_ingest(request.ingest));
  asked.update(
      asked_of_training(request.training, resolve_options(request.training, SceneFacts{})));
  asked[kCaptureFiles] = key_of(file_stamps(request.capture));
  asked[kWindows] = request.windows;
  return asked;
}

class Runner {
 public:
  /// `earlier`: what was in OUT before, from which the scene is taken where it is of the same; or
  /// "".
  Runner(const RunRequest& request, json asked, fs::path earlier, std::unique_ptr<ViewChild>& view)
      : request_(request),
        view_(view),
        asked_(std::move(asked)),
        planned_(resolve_options(request.training, SceneFacts{})),
        ingest_options_(resolve_ingest(request.ingest)),
        earlier_(std::move(earlier)),
        root_(request.out),
        run_{root_ / "run"},
        stages_(root_ / "stages.json") {}

  /// False when interrupted.
  bool run() {
    if (!stages_.ledger().done(kAsked, asked_)) stages_.ledger().begin(kAsked, asked_);
    if (!ingest()) return false;
    const SceneLock in_use(scene_, SceneLock::Use::kRead);
    planned_ = resolve_options(request_.training, scene_);
    check_max_bytes(scene_.string(), planned_.options.max_bytes);
    if (const std::string note = page_bytes_note(planned_.options.max_bytes); !note.empty())
      say(note);
    choose_windows_of_scene();
    if (!train() || !evaluate_model()) return false;
    if (!stages_.ledger().done(kAsked, asked_)) stages_.ledger().finish(kAsked, json::object());
    return export_frames() && write_player() && write_report();
  }

  json result() const {
    // places are those of now: OUT may have been copied, or named from elsewhere
    json result = stages_.ledger().result("evaluate");
    result["model"] = windows_ > 1 ? run_.root.string() : run_.model().string();
    result["training"] = stages_.ledger().result("train");
    result["training"][windows_ > 1 ? "folder" : "model"] = result["model"];
    result["camera_table"] = stages_.ledger().result("ingest").value("camera_table", json::array());
    result["export"] = request_.export_frames > 0 ? stages_.ledger().result("export")
                                                  : json{{"frames", 0}, {"bytes", 0}};
    result["export"]["folder"] = frames().string();
    if (carries_pages()) {
      result["player"] = stages_.ledger().result("player");
      result["player"]["folder"] = player().string();
    }
    if (stages_.ledger().is_finished(kReport.entry)) {
      const fs::path page = stages_.ledger().result("report")["page"].get<std::string>();
      result["report"] = (root_ / "report" / page.filename()).string();
    }
    result["metrics"] = run_.metrics().string();
    result["scene"] = scene_.string();
    result["out"] = request_.out.string();
    result["stage_seconds"] = stages_.seconds();
    result["total_seconds"] = seconds_since(begin_);
    result["camera_path"] = camera_path_of(scene_without_pixels(scene_, true));
    return result;
  }

 private:
  bool ingest() {
    IngestOptions options = ingest_options_;
    options.allow_static = planned_.options.motion == Motion::kNone;
    options.work = root_ / "work";
    json inputs = to_json(options);
    const bool as_it_is =
        inputs == to_json(defaults_for(options)) && opens_as_scene(request_.capture);
    scene_ = as_it_is ? request_.capture : root_ / "scene";
    inputs[kCaptureFiles] = asked_[kCaptureFiles];
    inputs["as it is"] = as_it_is;
    if (!earlier_.empty() && !as_it_is) take_scene(inputs);
    const fs::path product = as_it_is ? scene_ : scene_ / "transforms.json";
    const bool done = stages_.done(kIngest, inputs, product, [&] {
      json result = {{"scene", scene_.string()}};
      if (as_it_is) return std::optional(result);
      const IngestReport report =
          ingest_with_progress(request_.capture, scene_, options, request_.training.backend);
      result["frames"] = report.frames;
      result["cameras"] = report.cameras;
      result["warnings"] = report.warnings;
      result["camera_table"] = camera_table_json(report.camera_table);
      return std::optional(result);
    });
    // as recorded: a later version of the program has more options
    scene_key_ = key_of(stages_.ledger().inputs(kIngest.entry));
    return done;
  }

  /// The scene of the earlier run by links, where it was made of the same; where the file system
  /// has none, it is made again.
  void take_scene(const json& inputs) {
    const StageLedger before(earlier_ / "stages.json");
    if (!before.done(kIngest.entry, inputs)) return;
    std::error_code reason;
    fs::copy(earlier_ / "scene", scene_,
             fs::copy_options::recursive | fs::copy_options::create_hard_links, reason);
    if (reason)
      fs::remove_all(scene_);
    else
      stages_.ledger().adopt(kIngest.entry, before);
  }

  void choose_windows_of_scene() {
    const WindowChoice choice = cut_for_run(request_.windows, scene_, scene_key_,
                                            planned_.options.motion, run_.root, request_.gpus);
    if (!choice.reason.empty()) say(choice.reason);
    windows_ = choice.count;
  }

  bool train_windows_of_scene(json inputs) {
    inputs[kWindows] = windows_;
    const fs::path plan = WindowsFolder{run_.root}.plan_file();
    if (request_.view.view)
      warn(kTrain.message(fmt::format(": --view is of one training; of a window: tessera view {}",
                                      WindowsFolder{run_.root}.window_run(0).string())));
    return stages_.done(kTrain, inputs, plan, [&]() -> std::optional<json> {
      WindowsRequest windows;
      windows.scene = scene_;
      windows.root = run_.root;
      windows.arguments = request_.training;
      windows.files = scene_key_;
      windows.count = windows_;
      windows.gpus = request_.gpus;
      json result = train_windows(windows);
      if (interrupted() || result["left"].get<bool>()) return {};
      say(windows_text(result));
      return result;
    });
  }

  bool train() {
    json inputs = asked_of_training(request_.training, planned_);
    inputs[kSceneFiles] = scene_key_;
    if (windows_ > 1) return train_windows_of_scene(std::move(inputs));
    const RunAction action = action_in(request_.out, record_of(run_, scene_), inputs, false);
    if (stages_.ledger().is_finished(kTrain.entry) && fs::exists(run_.model()) &&
        !stages_.is_as_written(kTrain, run_.model()))
      throw InputError(fmt::format(
          "{}: is not the model that this run has trained: it was trained on, or is damaged; "
          "remove it to train again, or take another output folder",
          run_.model().string()));
    return stages_.done(kTrain, inputs, run_.model(), [&]() -> std::optional<json> {
      TrainingTerminal terminal;
      LiveTraining live(terminal, run_.root, [&] {
        if (request_.view.view && !view_)
          view_ = std::make_unique<ViewChild>(request_.out, repeated_command(), request_.view);
      });
      TrainRequest asked;
      asked.scene = scene_;
      asked.run = run_.root;
      take_arguments(request_.training, planned_, scene_key_, asked);
      asked.resume = action != RunAction::kStart;
      asked.snapshots = &live;
      json result = train_or_restart(std::move(asked), live);
      if (interrupted() || live.stopped()) return {};
      result.erase("scores");  // the evaluate stage has them
      return result;
    });
  }

  bool evaluate_model() {
    return stages_.done(kEvaluate, of_training({}), run_.metrics(), [&] {
      const std::unique_ptr<Backend> backend = make_backend(request_.training.backend);
      const json scores = score_clip(*backend, load_clip(run_.root), scene_, kHeldOutSplits);
      write_text_file(run_.metrics(), json_text(scores, 2));
      return std::optional(scores);
    });
  }

  /// Inputs of a stage that is made of the model.
  json of_training(json inputs) const {
    inputs["contents of the model"] = stages_.ledger().finished_at(kTrain.entry);
    return inputs;
  }

  fs::path frames() const { return root_ / "frames"; }
  fs::path player() const { return root_ / "player"; }

  bool export_frames() {
    if (request_.export_frames == 0) {
      if (fs::exists(frames() / "manifest.json"))
        warn(
            fmt::format("{}: holds the frames of an earlier run, which may be of another model; "
                        "remove the folder or pass --export-frames",
                        frames().string()));
      return true;
    }
    return stages_.done(
        kExport, of_training({{"export_frames", request_.export_frames}}),
        frames() / "manifest.json",
        [&] { return std::optional(write_run_frames(run_, frames(), request_.export_frames)); });
  }

  bool write_player() {
    if (!carries_pages()) {
      warn(kPage.message(
          ": not written, because nodejs and curl were not found when this program was built"));
      return true;
    }
    const fs::path folder = player();
    return stages_.done(
        kPage, of_training({{"title", request_.title}, {"description", request_.description}}),
        folder / kPageFile, [&] {
          return std::optional(
              write_run_player(run_, folder, request_.title, request_.description));
        });
  }

  /// A report that cannot be written is no reason to fail after hours of training.
  bool write_report() {
    const json inputs = of_training({{"export_frames", request_.export_frames}});
    try {
      return stages_.done(kReport, inputs, root_ / "report" / "report.json", [&] {
        return std::optional(json{{"page", write_run_report({{root_}, {}, [&] {
                                                               return make_backend(
                                                                   request_.training.backend);
                                                             }})["page"]}});
      });
    } catch (const InputError& error) {
      warn(kReport.message(fmt::format(": not written: {}", error.what())));
      return true;
    }
  }

  const RunRequest& request_;
  std::unique_ptr<ViewChild>& view_;
  const json asked_;
  PlannedOptions planned_;
  IngestOptions ingest_options_;
  const fs::path earlier_, root_;
  const RunFolder run_;
  RunStages stages_;
  fs::path scene_;
  std::string scene_key_;
  int64_t windows_ = 1;  // of the clip
  const Clock::time_point begin_ = Clock::now();
};

}  // namespace

std::optional<json> run_stages(const RunRequest& request, std::unique_ptr<ViewChild>& view) {
  TrainingTerminal messages;
  RunLock lock(request.out, messages);
  const json asked = asked_of(request);
  const RunFolder run{request.out / "run"};
  const StageLedger ledger(request.out / "stages.json");
  RunRecord record = record_of(run, request.capture);
  record.finished = ledger.is_finished(kTrain.entry) && record.has_model;
  record.request = ledger.inputs(kAsked);
  const RunAction action = action_in(request.out, record, asked, request.overwrite);
  if (action == RunAction::kStart) run.require_room();
  const fs::path earlier = action == RunAction::kReplace ? lock.make_room() : fs::path();
  for (const fs::path& folder : {request.out / "player", request.out / "frames"})
    if (has_foreign_contents(folder, "export"))
      throw InputError(fmt::format(
          "{}: has contents that no run has written, where this one would write; take another "
          "output folder, or move them away",
          folder.string()));
  for (const fs::path& folder : {request.out, run.root}) remove_partial_files(folder);
  try {
    Runner runner(request, asked, earlier, view);
    if (!runner.run()) return {};
    return runner.result();
  } catch (const Interrupted&) {
    return {};
  }
}

}  // namespace tessera
