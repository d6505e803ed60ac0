// What: `tessera run`: ingest → train → evaluate → export → page in one folder, each stage done
// once. Not: anything that the single commands do not do. OUT: scene/ (unless the capture is a
// prepared scene already), run/, frames/, player/, stages.json.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/input_folder.h"
#include "ingest/ingest.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/layouts/scene_reader.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/training/scene_scale.h"
#include "static3d/formats/frame_sequence.h"
#include "static3d/transform/world_change.h"
#include "tools/batch/ingest_batch.h"
#include "tools/camera_paths/export_times.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/cli/train_arguments.h"
#include "tools/cli/training_terminal.h"
#include "tools/export/in_time.h"
#include "tools/export/output_folder.h"
#include "tools/export/player_files.h"
#include "tools/player/player_page.h"
#include "tools/session/device_choice.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/output_place.h"
#include "tools/session/run_folder.h"
#include "tools/session/scene_lock.h"
#include "tools/session/stage_ledger.h"
#include "tools/session/train_session.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct RunRequest {
  fs::path capture, out;
  IngestArguments ingest;
  TrainArguments training;
  int64_t export_frames = 0;  // 0: those of a training camera, at most kMostFrames
  bool json_output = false;
};

IngestOptions defaults_for(const IngestOptions& options) {
  IngestOptions defaults;
  defaults.allow_static = options.allow_static;
  return defaults;
}

/// Stage by stage; each knows the key of the one before, so a change runs down the chain.
class Runner {
 public:
  explicit Runner(const RunRequest& request)
      : request_(request),
        options_(resolve_options(request.training, SceneFacts{})),
        ingest_options_(resolve_ingest(request.ingest)),
        run_{request.out / "run"},
        ledger_(request.out / "stages.json") {}

  /// False when interrupted; what is done is kept.
  bool run() {
    ingest();
    const SceneLock in_use(scene_, SceneLock::Use::kRead);
    options_ = resolve_options(request_.training, scene_);
    if (const std::string note = page_bytes_note(options_.max_bytes); !note.empty()) say(note);
    return train() && evaluate_model() && export_frames() && write_player();
  }

  json result() const {
    json result = ledger_.result("evaluate");
    result["training"] = ledger_.result("train");
    result["export"] = ledger_.result("export");
    if (carries_player_page()) result["player"] = ledger_.result("player");
    result["model"] = run_.model().string();
    result["out"] = request_.out.string();
    return result;
  }

 private:
  static constexpr int64_t kMostFrames = 60;

  /// Whether the stage must run: not done for this key, or `product` is gone. Says so either way.
  bool must_run(const std::string& stage, const std::string& key, const fs::path& product) {
    const bool done = ledger_.done(stage, key) && fs::exists(product);
    say(fmt::format("{}: {}", stage, done ? "done before, unchanged" : "begins"));
    return !done;
  }

  SceneOptions scene_options(bool pixels) const {
    return {parse_background(options_.background), options_.static_only, pixels, {}};
  }

  void ingest() {
    IngestOptions options = ingest_options_;
    options.allow_static = options_.static_only;
    options.work = request_.out / "work";
    const bool as_it_is =
        to_json(options) == to_json(defaults_for(options)) && opens_as_scene(request_.capture);
    scene_ = as_it_is ? request_.capture : request_.out / "scene";
    const std::string key = key_of({file_stamps(request_.capture), to_json(options), as_it_is});
    scene_key_ = key;
    if (!must_run("ingest", key, as_it_is ? scene_ : scene_ / "transforms.json")) return;
    ledger_.begin("ingest", key);
    json result = {{"scene", scene_.string()}};
    if (!as_it_is) {
      const IngestReport report = ingest_with_progress(request_.capture, scene_, options, "ingest");
      result["frames"] = report.frames;
      result["cameras"] = report.cameras;
    }
    ledger_.finish("ingest", key, result);
  }

  bool train() {
    const std::string backend = parse_backend(request_.training.backend).name;
    train_key_ = key_of({scene_key_, to_json(options_), backend});
    if (!must_run("train", train_key_, run_.model())) return true;
    TrainRequest train;
    train.scene = scene_;
    train.run = run_.root;
    train.options = options_;
    train.preset = request_.training.preset;
    train.ablation = request_.training.ablation;
    train.backend = request_.training.backend;
    train.evaluate_every = request_.training.evaluate_every;
    train.checkpoint_every = request_.training.checkpoint_every;
    train.made_for = train_key_;
    train.resume = run_.made_for() == train_key_ && fs::exists(run_.checkpoint());
    train.overwrite = true;
    train.shipped_bytes = shipped_bytes_of(run_.root.string());
    ledger_.begin("train", train_key_);
    TrainingTerminal terminal;
    json result = train_or_restart(std::move(train), terminal);
    if (interrupted()) return false;
    result.erase("scores");  // the evaluate stage has them
    ledger_.finish("train", train_key_, result);
    return true;
  }

  bool evaluate_model() {
    const std::string key = key_of({train_key_, "evaluate"});
    if (!must_run("evaluate", key, run_.metrics())) return true;
    ledger_.begin("evaluate", key);
    const GaussianModel model = load_model(run_.model());
    const Scene scene = scaled_scene(load_scene(scene_, scene_options(true)), model.train_scale);
    const std::unique_ptr<Backend> backend = make_backend(request_.training.backend);
    const json scores = score_splits(*backend, model, scene, held_out_splits(scene),
                                     int64_t(fs::file_size(run_.model())));
    write_text_file(run_.metrics(), scores.dump(2));
    ledger_.finish("evaluate", key, scores);
    return !interrupted();
  }

  std::vector<double> export_times() const {
    if (request_.export_frames > 0)
      return tessera::export_times({.frames = request_.export_frames}, {}, true);
    const Scene scene = load_scene(scene_, scene_options(false));
    CameraTimesteps timesteps;
    for (int i : scene.split_indices(Split::kTrain)) {
      const Frame& frame = scene.frames[size_t(i)];
      timesteps[frame.camera_name].insert(frame.time);
    }
    return capture_times(timesteps, kMostFrames);
  }

  static std::vector<std::string> sequence_files(size_t count) {
    std::vector<std::string> files{"manifest.json"};
    for (size_t i = 0; i < count; ++i)
      files.push_back(sequence_file_name(int64_t(i), int64_t(count), splat_format("ply")));
    return files;
  }

  bool export_frames() {
    const std::string key = key_of({train_key_, "export", request_.export_frames});
    const fs::path folder = request_.out / "frames";
    if (!must_run("export", key, folder / "manifest.json")) return true;
    ledger_.begin("export", key);
    const GaussianModel model = model_in_source_world(load_model(run_.model()));
    if (model.environment.height > 0)
      warn("the environment is not in the frames, which are 3DGS files; the model keeps it");
    const std::vector<double> times = export_times();
    OutputFolder output(folder, "run", sequence_files(times.size()), true);
    ProgressBar bar("export");
    const SequenceReport report = export_sequence(
        model, output.staging(), times, splat_format("ply"), [&](int64_t done, int64_t total) {
          stop_if_interrupted();
          bar.update(done, total);
        });
    output.finish();
    ledger_.finish(
        "export", key,
        {{"folder", folder.string()}, {"frames", report.frames.size()}, {"bytes", report.bytes}});
    return true;
  }

  /// One page that opens by itself, or a folder for a web server where that would be too much for
  /// a browser to open in one piece.
  bool write_player() {
    if (!carries_player_page()) {
      warn("this build carries no player page (nodejs and npm were not there): none is written");
      return true;
    }
    const std::string key = key_of({train_key_, "player"});
    const fs::path folder = request_.out / "player";
    if (!must_run("player", key, folder / kPageFile)) return true;
    ledger_.begin("player", key);
    GaussianModel model = model_in_source_world(load_model(run_.model()));
    ExportRequest page;
    page.model = run_.root.string();
    page.out = folder.string();
    page.overwrite = true;
    constexpr int64_t kMostInside = int64_t{64} << 20;  // bytes
    page.format = "html";
    json written = find_time_format(page.format)->write(page, model);
    if (written["scene_bytes"] > kMostInside) {
      page.format = "page";
      written = find_time_format(page.format)->write(page, model);
    }
    written["folder"] = folder.string();
    written["format"] = page.format;
    ledger_.finish("player", key, written);
    return !interrupted();
  }

  const RunRequest& request_;
  TrainOptions options_;
  IngestOptions ingest_options_;
  RunFolder run_;
  StageLedger ledger_;
  fs::path scene_;
  std::string scene_key_, train_key_;
};

std::string player_text(const json& result) {
  if (!result.contains("player")) return "";
  const json& player = result["player"];
  const std::string folder = player["folder"];
  const double megabytes = player["bytes"].get<double>() / 1e6;
  if (player["format"] == "html")
    return fmt::format("\nplayer   {}/{} ({:.1f} MB): open it in a browser", folder, kPageFile,
                       megabytes);
  return fmt::format(
      "\nplayer   {} ({:.1f} MB): `python3 -m http.server -d {}`, then http://localhost:8000",
      folder, megabytes, folder);
}

std::string run_text(const json& result) {
  const json& exported = result["export"];
  const std::string scores = scores_text(result);
  return fmt::format(
      "result   {}\nmodel    {}\nquality  {}\nframes   {} of .ply in {} ({:.1f} MB): open "
      "them together in a splat viewer that plays sequences, e.g. SuperSplat{}",
      result["out"].get<std::string>(), result["model"].get<std::string>(),
      scores.empty() ? "no held-out frames" : scores, exported["frames"].get<int64_t>(),
      exported["folder"].get<std::string>(), exported["bytes"].get<double>() / 1e6,
      player_text(result));
}

/// What can be refused before anything is written, and not only after hours.
void check_request(const RunRequest& request) {
  const fs::path& capture = request.capture;
  const IngestOptions options = resolve_ingest(request.ingest);
  require_folder(capture);
  if (is_folder_of_captures(capture, options.reading))
    throw InputError(fmt::format(
        "{}: holds several captures ({}); name one of them, or prepare all with `tessera ingest`",
        capture.string(), fmt::join(captures_in(capture, options.reading), ", ")));
  check_output_apart(request.out, capture);
  if (!opens_as_scene(capture)) layout_of(capture, options);
  is_cuda_chosen(request.training.backend);
}

}  // namespace

void add_run_command(CLI::App& app, Work& work) {
  const auto request = std::make_shared<RunRequest>();
  CLI::App& command = *app.add_subcommand(
      "run", "capture -> prepared scene, model, scores, player files; run again to resume");
  command.add_option("capture", request->capture, "folder of videos or images")->required();
  command.add_option("-o,--out", request->out, "output folder")->required();
  add_ingest_options(command, request->ingest);
  command.add_option("--export-frames", request->export_frames,
                     "frames of the .ply sequence; 0: as many as a camera filmed, at most 60");
  command.add_flag("--json", request->json_output, "print one JSON object");
  add_train_options(command, request->training);
  command.callback([request, &work] {
    work = [request] {
      set_thread_count(request->training.threads);
      check_request(*request);
      Runner runner(*request);
      if (!runner.run()) {
        say("interrupted; run the same command again to go on");
        return stop_code();
      }
      const json result = runner.result();
      print_result(request->json_output, result, run_text(result));
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
