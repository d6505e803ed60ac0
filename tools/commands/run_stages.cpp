// Runs the stages in order. The key of each stage contains the key of the stage before it, so that
// a change reruns all later stages.
#include "tools/commands/run_stages.h"

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/ingest.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/seconds_since.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/scene_scale.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/training_terminal.h"
#include "tools/export/formats.h"
#include "tools/export/player_files.h"
#include "tools/export/run_outputs.h"
#include "tools/live/live_training.h"
#include "tools/live/view_child.h"
#include "tools/player/player_page.h"
#include "tools/report/write_run_report.h"
#include "tools/session/device_choice.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/session/train_session.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

IngestOptions defaults_for(const IngestOptions& options) {
  IngestOptions defaults;
  defaults.allow_static = options.allow_static;
  return defaults;
}

struct Stage {
  int number;
  const char *name, *entry;  // in messages; in stages.json

  std::string message(const std::string& text) const {
    return fmt::format("[{}/6] {}{}", number, name, text);
  }
};
constexpr Stage kIngest{1, "ingest", "ingest"}, kTrain{2, "train", "train"},
    kEvaluate{3, "evaluate", "evaluate"}, kExport{4, "export", "export"},
    kPage{5, "page", "player"}, kReport{6, "report", "report"};

class Runner {
 public:
  Runner(const RunRequest& request, std::unique_ptr<ViewChild>& view)
      : request_(request),
        view_(view),
        planned_(resolve_options(request.training, SceneFacts{})),
        ingest_options_(resolve_ingest(request.ingest)),
        run_{request.out / "run"},
        ledger_(request.out / "stages.json") {}

  /// False when interrupted.
  bool run() {
    if (!ingest()) return false;
    const SceneLock in_use(scene_, SceneLock::Use::kRead);
    planned_ = resolve_options(request_.training, scene_);
    check_max_bytes(scene_.string(), planned_.options.max_bytes);
    if (const std::string note = page_bytes_note(planned_.options.max_bytes); !note.empty())
      say(note);
    return train() && evaluate_model() && export_frames() && write_player() && write_report();
  }

  json result() const {
    json result = ledger_.result("evaluate");
    result["training"] = ledger_.result("train");
    result["export"] = request_.export_frames > 0
                           ? ledger_.result("export")
                           : json{{"folder", frames().string()}, {"frames", 0}, {"bytes", 0}};
    if (carries_player_page()) result["player"] = ledger_.result("player");
    if (fs::exists(report_page())) result["report"] = report_page().string();
    result["model"] = run_.model().string();
    result["metrics"] = run_.metrics().string();
    result["scene"] = scene_.string();
    result["out"] = request_.out.string();
    result["stage_seconds"] = seconds_;
    result["total_seconds"] = seconds_since(begin_);
    result["camera_path"] = camera_path_of(load_scene(scene_, scene_options(false)));
    return result;
  }

 private:
  /// Does the stage unless it was done for this key and `product` is still there. `make` returns
  /// its result, nothing where it was stopped before its end. False when interrupted.
  bool do_stage(const Stage& stage, const std::string& key, const fs::path& product,
                const std::function<std::optional<json>()>& make) {
    if (ledger_.done(stage.entry, key) && fs::exists(product)) {
      say(stage.message(": done before, unchanged"));
      return true;
    }
    say(stage.message(""));
    const auto begin = Clock::now();
    ledger_.begin(stage.entry, key);
    const std::optional<json> result = make();
    if (!result) return false;
    seconds_[stage.name] = seconds_since(begin);
    ledger_.finish(stage.entry, key, *result, seconds_[stage.name]);
    say(stage.message(fmt::format(": done in {}", duration_text(seconds_[stage.name]))));
    return !interrupted();
  }

  SceneOptions scene_options(bool pixels) const {
    return {parse_background(planned_.options.background),
            planned_.options.motion == Motion::kNone,
            pixels,
            {}};
  }

  bool ingest() {
    IngestOptions options = ingest_options_;
    options.allow_static = planned_.options.motion == Motion::kNone;
    options.work = request_.out / "work";
    const bool as_it_is =
        to_json(options) == to_json(defaults_for(options)) && opens_as_scene(request_.capture);
    scene_ = as_it_is ? request_.capture : request_.out / "scene";
    scene_key_ = key_of({file_stamps(request_.capture), to_json(options), as_it_is});
    return do_stage(kIngest, scene_key_, as_it_is ? scene_ : scene_ / "transforms.json", [&] {
      json result = {{"scene", scene_.string()}};
      if (as_it_is) return std::optional(result);
      const IngestReport report = ingest_with_progress(request_.capture, scene_, options, "ingest");
      result["frames"] = report.frames;
      result["cameras"] = report.cameras;
      result["warnings"] = report.warnings;
      return std::optional(result);
    });
  }

  bool train() {
    const std::string backend = parse_backend(request_.training.backend).name;
    train_key_ = key_of({scene_key_, to_json(planned_.options), backend});
    return do_stage(kTrain, train_key_, run_.model(), [&]() -> std::optional<json> {
      TrainingTerminal terminal;
      LiveTraining live(terminal, run_.root, [&] {
        if (request_.view) view_ = std::make_unique<ViewChild>(request_.out);
      });
      TrainRequest asked = train_request();
      asked.snapshots = &live;
      json result = train_or_restart(std::move(asked), live);
      if (interrupted() || live.stopped()) return {};
      result.erase("scores");  // the evaluate stage has them
      return result;
    });
  }

  TrainRequest train_request() const {
    TrainRequest train;
    train.scene = scene_;
    train.run = run_.root;
    train.options = planned_.options;
    train.with_nodes = planned_.with_nodes;
    train.preset = request_.training.preset;
    train.ablation = request_.training.ablation;
    train.backend = request_.training.backend;
    train.evaluate_every = request_.training.evaluate_every;
    train.checkpoint_every = request_.training.checkpoint_every;
    train.made_for = train_key_;
    train.resume = run_.made_for() == train_key_ && fs::exists(run_.checkpoint());
    train.overwrite = true;
    train.shipped_bytes = shipped_bytes_of(run_.root.string());
    return train;
  }

  bool evaluate_model() {
    return do_stage(kEvaluate, key_of({train_key_, "evaluate"}), run_.metrics(), [&] {
      const GaussianModel model = load_model(run_.model());
      const Scene scene = scaled_scene(load_scene(scene_, scene_options(true)), model.train_scale);
      const std::unique_ptr<Backend> backend = make_backend(request_.training.backend);
      ProgressBar bar("evaluate");
      const json scores = score_splits(
          *backend, model, scene, held_out_splits(scene), int64_t(fs::file_size(run_.model())),
          [&](const Frame&, const RenderedImage&, const ViewScore& view, int64_t done,
              int64_t total) {
            stop_if_interrupted();
            bar.update(done, total, fmt::format("{:.2f} dB", view.psnr));
          });
      write_text_file(run_.metrics(), scores.dump(2));
      return std::optional(scores);
    });
  }

  fs::path frames() const { return request_.out / "frames"; }

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
    return do_stage(
        kExport, key_of({train_key_, "export", request_.export_frames}), frames() / "manifest.json",
        [&] { return std::optional(write_run_frames(run_, frames(), request_.export_frames)); });
  }

  bool write_player() {
    if (!carries_player_page()) {
      warn(kPage.message(
          ": not written, because nodejs and npm were not found when this program was built"));
      return true;
    }
    const fs::path folder = request_.out / "player";
    return do_stage(kPage, key_of({train_key_, "player", request_.title, request_.description}),
                    folder / kPageFile, [&] {
                      return std::optional(
                          write_run_player(run_, folder, request_.title, request_.description));
                    });
  }

  fs::path report_page() const { return request_.out / "report" / "index.html"; }

  /// A report that cannot be written is no reason to fail after hours of training.
  bool write_report() {
    const std::string key = key_of({train_key_, "report", request_.export_frames});
    try {
      return do_stage(kReport, key, report_page(), [&] {
        return std::optional(json{{"page", write_run_report({request_.out, {}, [&] {
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
  PlannedOptions planned_;
  IngestOptions ingest_options_;
  RunFolder run_;
  StageLedger ledger_;
  fs::path scene_;
  std::string scene_key_, train_key_;
  const Clock::time_point begin_ = Clock::now();
  std::map<std::string, double> seconds_;  // by the names of the stages that ran
};

}  // namespace

std::optional<json> run_stages(const RunRequest& request, std::unique_ptr<ViewChild>& view) {
  try {
    Runner runner(request, view);
    if (!runner.run()) return {};
    return runner.result();
  } catch (const Interrupted&) {
    return {};
  }
}

}  // namespace tessera
