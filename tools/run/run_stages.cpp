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
#include "ingest/ingest.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/seconds_since.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/run_record.h"
#include "tools/cli/training_terminal.h"
#include "tools/export/formats.h"
#include "tools/export/player_files.h"
#include "tools/export/run_outputs.h"
#include "tools/export/run_successor.h"
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
#include "tools/windows/train_windows.h"
#include "tools/windows/window_choice.h"
#include "tools/windows/windows_result.h"
#include "tools/windows/windows_scores.h"

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

constexpr RunStage kIngest{1, "ingest", "ingest", false}, kTrain{2, "train", "train"},
    kEvaluate{3, "evaluate", "evaluate"}, kExport{4, "export", "export"},
    kPage{5, "page", "player"}, kReport{6, "report", "report"};

constexpr const char* kWindowsKey = "windows";
constexpr const char* kAsked = "asked";  // the entry of the request, which is done with the run

/// What a run is asked for, but for what is made anew in seconds.
json asked_of(const RunRequest& request) {
  json asked = to_json(resolve_ingest(request.ingest));
  asked["files of the capture"] = key_of(file_stamps(request.capture));
  asked[kWindowsKey] = request.windows;
  asked.update(
      asked_of_training(request.training, resolve_options(request.training, SceneFacts{})));
  return asked;
}

/// A training that was decided on after its scene was known would replace a finished one.
struct Replaces {};

class Runner {
 public:
  /// `root`: OUT, or the folder in it in which the successor of a finished run is made.
  Runner(const RunRequest& request, json asked, fs::path root, std::unique_ptr<ViewChild>& view)
      : request_(request),
        view_(view),
        asked_(std::move(asked)),
        planned_(resolve_options(request.training, SceneFacts{})),
        ingest_options_(resolve_ingest(request.ingest)),
        root_(std::move(root)),
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
    if (root_ != request_.out) take_place();
    return export_frames() && write_player() && write_report();
  }

  json result() const {
    json result = stages_.ledger().result("evaluate");
    result["training"] = stages_.ledger().result("train");
    result["camera_table"] = stages_.ledger().result("ingest").value("camera_table", json::array());
    result["export"] = request_.export_frames > 0
                           ? stages_.ledger().result("export")
                           : json{{"folder", frames().string()}, {"frames", 0}, {"bytes", 0}};
    if (carries_pages()) result["player"] = stages_.ledger().result("player");
    if (stages_.ledger().is_finished(kReport.entry))
      result["report"] = stages_.ledger().result("report")["page"];
    result["model"] = windows_ > 1 ? run_.root.string() : run_.model().string();
    result["metrics"] = run_.metrics().string();
    result["scene"] = scene_.string();
    result["out"] = request_.out.string();
    result["stage_seconds"] = stages_.seconds();
    result["total_seconds"] = seconds_since(begin_);
    result["camera_path"] = camera_path_of(scene_without_pixels(scene_, true));
    return result;
  }

 private:
  /// The complete successor of a finished run moves from root_ to OUT.
  void take_place() {
    const fs::path from = root_;
    root_ = request_.out;
    move_successor(from, root_);
    run_ = RunFolder{root_ / "run"};
    if (scene_ == from / "scene") scene_ = root_ / "scene";
    stages_.ledger() = StageLedger(root_ / "stages.json");
  }

  bool ingest() {
    IngestOptions options = ingest_options_;
    options.allow_static = planned_.options.motion == Motion::kNone;
    options.work = root_ / "work";
    json inputs = to_json(options);
    const bool as_it_is =
        inputs == to_json(defaults_for(options)) && opens_as_scene(request_.capture);
    scene_ = as_it_is ? request_.capture : root_ / "scene";
    inputs["files of the capture"] = asked_["files of the capture"];
    inputs["as it is"] = as_it_is;
    scene_key_ = key_of(inputs);
    if (root_ != request_.out) share_scene(inputs, as_it_is);
    return stages_.done(kIngest, inputs, as_it_is ? scene_ : scene_ / "transforms.json", [&] {
      json result = {{"scene", scene_.string()}};
      if (as_it_is) return std::optional(result);
      const IngestReport report = ingest_with_progress(request_.capture, scene_, options);
      result["frames"] = report.frames;
      result["cameras"] = report.cameras;
      result["warnings"] = report.warnings;
      result["camera_table"] = camera_table_json(report.camera_table);
      return std::optional(result);
    });
  }

  /// A successor has the scene of the finished run where that is made of the same.
  void share_scene(const json& inputs, bool as_it_is) {
    const StageLedger before(request_.out / "stages.json");
    const fs::path made = as_it_is ? scene_ : request_.out / "scene";
    if (!before.done(kIngest.entry, inputs) || !fs::exists(made)) return;
    scene_ = made;
    stages_.ledger().adopt(kIngest.entry, before);
  }

  void choose_windows_of_scene() {
    const WindowChoice choice = choose_windows(request_.windows, scene_, planned_.options.motion);
    if (!choice.reason.empty()) say(choice.reason);
    windows_ = choice.count;
  }

  /// A finished training of another request is refused, or replaced where that is asked for.
  void check_finished(const RunPlan& plan) const {
    if (plan.action == RunAction::kRefuse) throw finished_run_error(request_.out, plan.changed);
    // a successor that is finished and not in its place yet is no result of anybody
    if (plan.action == RunAction::kReplace && root_ == request_.out) throw Replaces{};
  }

  bool train_windows_of_scene(json inputs) {
    inputs[kWindowsKey] = windows_;
    const fs::path plan = WindowsFolder{run_.root}.plan_file();
    check_finished(plan_run({false, fs::exists(plan), stages_.ledger().is_finished(kTrain.entry),
                             stages_.ledger().inputs(kTrain.entry)},
                            inputs, request_.overwrite));
    if (request_.view)
      warn(kTrain.message(fmt::format(": --view is of one training; of a window: tessera view {}",
                                      WindowsFolder{run_.root}.window_run(0).string())));
    return stages_.done(kTrain, inputs, plan, [&]() -> std::optional<json> {
      WindowsRequest windows;
      windows.scene = scene_;
      windows.root = run_.root;
      windows.arguments = request_.training;
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
    const RunPlan plan = plan_run(
        {fs::exists(run_.checkpoint()), fs::exists(run_.model()),
         stages_.ledger().is_finished(kTrain.entry), stages_.ledger().inputs(kTrain.entry)},
        inputs, request_.overwrite);
    check_finished(plan);
    if (plan.action == RunAction::kDone && fs::exists(run_.model()) &&
        !stages_.is_as_written(kTrain, run_.model()))
      throw InputError(fmt::format(
          "{}: is not the model that this run has trained: it was trained on, or is damaged; "
          "remove it to train again, or take another output folder",
          run_.model().string()));
    const json made_for = json::parse(run_.made_for(), nullptr, false);
    const bool resumes = plan.action == RunAction::kResume && made_for.is_object() &&
                         changes(made_for, inputs).empty();
    if (!resumes && plan.action != RunAction::kDone && fs::exists(run_.checkpoint()))
      set_checkpoint_aside(plan.changed);
    if (plan.action != RunAction::kDone) set_windows_aside();
    return stages_.done(kTrain, inputs, run_.model(), [&]() -> std::optional<json> {
      TrainingTerminal terminal;
      LiveTraining live(terminal, run_.root, [&] {
        if (request_.view && !view_)
          view_ = std::make_unique<ViewChild>(request_.out, repeated_command());
      });
      TrainRequest asked;
      asked.scene = scene_;
      asked.run = run_.root;
      take_arguments(request_.training, planned_, scene_key_, asked);
      asked.resume = resumes;
      asked.overwrite = true;
      asked.snapshots = &live;
      json result = train_or_restart(std::move(asked), live);
      if (interrupted() || live.stopped()) return {};
      result.erase("scores");  // the evaluate stage has them
      return result;
    });
  }

  /// An unfinished training of another request is hours of work, too.
  void set_checkpoint_aside(const std::vector<std::string>& changed) {
    const fs::path checkpoint = run_.checkpoint(), aside = run_.set_checkpoint_aside();
    warn(text_of_aside(checkpoint, changed, aside));
  }

  /// Windows of an unfinished run are no part of this one.
  void set_windows_aside() const {
    const fs::path plan = WindowsFolder{run_.root}.plan_file();
    if (!fs::exists(plan)) return;
    fs::remove(plan);
    warn(fmt::format(
        "{}: is of an unfinished run in windows, and gone; those that were trained stay "
        "and are taken up where the same windows are asked for again",
        plan.string()));
  }

  bool evaluate_model() {
    return stages_.done(kEvaluate, of_training({}), run_.metrics(), [&] {
      const std::unique_ptr<Backend> backend = make_backend(request_.training.backend);
      const json scores = windows_ > 1
                              ? score_windows(*backend, WindowsFolder{run_.root}, kHeldOutSplits)
                              : scores_of_model(*backend);
      write_text_file(run_.metrics(), scores.dump(2));
      return std::optional(scores);
    });
  }

  json scores_of_model(Backend& backend) const {
    const GaussianModel model = load_model(run_.model());
    const Scene scene = scaled_scene(
        scene_for(model, run_.root, scene_, {.pixels_of = kHeldOutSplits}), model.train_scale);
    ProgressBar bar("evaluate");
    return score_splits(backend, model, scene, held_out_splits(scene),
                        int64_t(fs::file_size(run_.model())),
                        [&](const Frame&, const RenderedImage&, const ViewScore& view, int64_t done,
                            int64_t total) {
                          stop_if_interrupted();
                          bar.update(done, total, fmt::format("{:.2f} dB", view.psnr));
                        });
  }

  /// Inputs of a stage that is made of the model.
  json of_training(json inputs) const {
    inputs["files of the model"] = stages_.ledger().finished_at(kTrain.entry);
    return inputs;
  }

  fs::path frames() const { return root_ / "frames"; }

  bool export_frames() {
    if (request_.export_frames == 0) {
      say(kExport.message(": no PLY frames are requested (--export-frames N writes N of them)"));
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
          ": not written, because nodejs and npm were not found when this program was built"));
      return true;
    }
    const fs::path folder = root_ / "player";
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
  json asked_;
  PlannedOptions planned_;
  IngestOptions ingest_options_;
  fs::path root_;
  RunFolder run_;
  RunStages stages_;
  fs::path scene_;
  std::string scene_key_;
  int64_t windows_ = 1;  // of the clip
  const Clock::time_point begin_ = Clock::now();
};

}  // namespace

std::optional<json> run_stages(const RunRequest& request, std::unique_ptr<ViewChild>& view) {
  TrainingTerminal messages;
  const RunLock lock(request.out, messages);
  const json asked = asked_of(request);
  finish_move(request.out);
  const StageLedger ledger(request.out / "stages.json");
  const RunFolder run{request.out / "run"};
  run.require_no_foreign_file();
  for (const fs::path& folder : {request.out / "player", request.out / "frames"})
    if (has_foreign_contents(folder, "export"))
      throw InputError(fmt::format(
          "{}: has contents that no run has written, where this one would write; take another "
          "output folder, or move them away",
          folder.string()));
  for (const fs::path& folder : {request.out, run.root}) remove_partial_files(folder);
  const bool has_model = fs::exists(run.model()) || WindowsFolder{run.root}.exists();
  const bool is_finished = ledger.is_finished(kTrain.entry) && has_model;
  const RunPlan plan =
      plan_run({fs::exists(run.checkpoint()), has_model, is_finished, ledger.inputs(kAsked)}, asked,
               request.overwrite);
  if (plan.action == RunAction::kRefuse) throw finished_run_error(request.out, plan.changed);
  const fs::path next = request.out / kNext;
  const auto run_in = [&](const fs::path& root) -> std::optional<json> {
    Runner runner(request, asked, root, view);
    if (!runner.run()) return {};
    return runner.result();
  };
  try {
    if (plan.action == RunAction::kReplace) return run_in(next);
    try {
      return run_in(request.out);
    } catch (const Replaces&) {
      return run_in(next);
    }
  } catch (const Interrupted&) {
    return {};
  }
}

}  // namespace tessera
