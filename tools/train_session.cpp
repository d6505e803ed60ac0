// What: load the scene, start or resume, train in stretches between checkpoints and evaluations,
//       write the run folder.
// Not: a step (recon4d/trainer.cpp).
#include "tools/train_session.h"

#include <fmt/format.h>

#include <utility>

#include "ingest/dense_cloud.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/scene_reader.h"
#include "kernels/base/errors.h"
#include "recon4d/checkpoint.h"
#include "recon4d/model_file.h"
#include "recon4d/scene_scale.h"
#include "recon4d/trainer.h"
#include "tools/backend_choice.h"
#include "tools/held_out_scores.h"
#include "tools/interrupt.h"
#include "tools/run_folder.h"
#include "tools/training_log.h"
#include "tools/version.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Tells scenes apart on resume: names, times and sizes of the frames, and their masks.
std::string scene_fingerprint(const Scene& scene) {
  Fnv1a hash;
  for (const Frame& frame : scene.frames) {
    hash.add(
        fmt::format("{} {} {} {};", frame.name, frame.time, frame.image.width, frame.image.height));
    hash.add(frame.mask.data.data(), frame.mask.data.size());
  }
  return hash.hex();
}

/// What the run folder already holds, if it may be used.
std::optional<Checkpoint> previous_state(const TrainRequest& request, const RunFolder& run) {
  if (!run.exists()) {
    if (request.resume)
      throw InputError(
          fmt::format("{}: nothing to resume: it has no config.json", run.root.string()));
    return std::nullopt;
  }
  if (request.resume && std::filesystem::exists(run.checkpoint()))
    return load_checkpoint(run.checkpoint());
  if (!request.resume && !request.overwrite)
    throw InputError(fmt::format(
        "{}: holds a run already; pass --resume to go on with it or --overwrite to replace it",
        run.root.string()));
  run.remove_files();
  return std::nullopt;
}

json make_config(const TrainRequest& request, const TrainOptions& options, const Scene& scene,
                 const std::string& device) {
  return {{"tessera", kVersionText},
          {"preset", request.preset},
          {"ablation", request.ablation.empty() ? json(nullptr) : json(request.ablation)},
          {"options", to_json(options)},
          {"scene", std::filesystem::absolute(request.scene).string()},
          {"scene_fingerprint", scene_fingerprint(scene)},
          {"train_frames", scene.split_indices(Split::kTrain).size()},
          {"device", device},
          {"seed", options.seed}};
}

/// Where training pauses next: the end, a checkpoint, an evaluation, the stop that was asked for.
int64_t next_pause(int64_t iteration, int64_t end, const TrainRequest& request) {
  int64_t next = end;
  for (int64_t every : {request.checkpoint_every, request.evaluate_every})
    if (every > 0) next = std::min(next, (iteration / every + 1) * every);
  return next;
}

json score(Backend& backend, Trainer& trainer, const Scene& scene, TrainingLog& log) {
  const TrainState& state = trainer.state();
  json scores =
      score_splits(backend, trainer.host_model(), scene, held_out_splits(scene), std::nullopt);
  json brief = json::object();
  if (scores.contains("splits"))
    for (const auto& [split, of_split] : scores["splits"].items())
      brief[split] = {{"psnr", of_split["psnr"]}, {"ssim", of_split["ssim"]}};
  for (const auto& [split, of_split] : brief.items())
    say(fmt::format("step {}: {} PSNR {} dB, {} Gaussians", state.iteration, split,
                    of_split["psnr"].dump().substr(0, 5), state.model.count()));
  log.event("evaluation", {{"iteration", state.iteration},
                           {"seconds", state.seconds},
                           {"num_gaussians", state.model.count()},
                           {"splits", brief}});
  return scores;
}

/// Stages and memory of training; evaluations use the same backend and are left out.
class StageLog {
 public:
  explicit StageLog(Backend& backend) : memory_(backend.memory()), clock_(backend.clock()) {}

  void run(Trainer& trainer, int64_t iteration) {
    const std::array<StageTotals, kStages> before = clock_.totals();
    trainer.run(iteration, interrupted);
    const std::array<StageTotals, kStages> after = clock_.totals();
    peak_ = memory_.peak_bytes();
    for (size_t s = 0; s < kStages; ++s) {
      sum_[s].seconds += after[s].seconds - before[s].seconds;
      sum_[s].bytes += after[s].bytes - before[s].bytes;
    }
  }
  void add_to(json& result) const {
    result["peak_device_bytes"] = peak_;
    for (size_t s = 0; s < kStages; ++s) {
      const StageTotals& t = sum_[s];
      result["stage_ms"][kStageNames[s]] = 1000 * t.seconds;
      result["stage_gbytes"][kStageNames[s]] = t.bytes / 1e9;
      result["stage_gb_per_s"][kStageNames[s]] = t.seconds > 0 ? t.bytes / 1e9 / t.seconds : 0;
    }
  }

 private:
  Memory& memory_;
  StageClock& clock_;
  std::array<StageTotals, kStages> sum_{};
  int64_t peak_ = 0;  // before the evaluation that follows the last stretch
};

json summary(const Trainer& trainer, const json& scores, Backend& backend) {
  const TrainState& state = trainer.state();
  return {{"seconds", state.seconds},
          {"iterations", state.iteration},
          {"finished", state.finished},
          {"num_gaussians", state.model.count()},
          {"num_static", state.model.static_set.count()},
          {"num_dynamic", state.model.dynamic_set.count()},
          {"device", backend.name()},
          {"scores", scores}};
}

}  // namespace

Scene load_training_scene(const std::filesystem::path& path, const TrainOptions& options) {
  SceneOptions scene_options;
  scene_options.background = parse_background(options.background);
  scene_options.allow_static = options.static_only;
  return scaled_scene(load_scene(path, scene_options), options.train_scale);
}

void complete_cloud(Scene& scene, const TrainOptions& options) {
  if (!options.sweep || !scene.points.position.empty()) return;
  scene.points = dense_cloud(scene, {options.init_points, uint64_t(options.seed), {}});
}

json train_session(const TrainRequest& request) {
  const RunFolder run{request.run};
  std::optional<Checkpoint> previous = previous_state(request, run);
  const TrainOptions options = previous ? previous->options : request.options;
  validate(options);
  Scene scene = load_training_scene(request.scene, options);
  if (!previous) complete_cloud(scene, options);
  for (const std::string& warning : scene.warnings) warn(warning);
  const std::unique_ptr<Backend> backend = make_backend(request.backend);
  const json config = make_config(request, options, scene, backend->name());
  if (previous && previous->provenance.value("scene_fingerprint", "") !=
                      config["scene_fingerprint"].get<std::string>())
    throw InputError(
        fmt::format("{}: was trained on other frames than {} holds; resume with the "
                    "scene it was started on",
                    run.checkpoint().string(), request.scene.string()));
  make_folder(run.root);
  std::string source = "checkpoint";
  TrainState start = previous ? std::move(previous->state) : initial_state(scene, options, source);
  if (!previous) write_text_file(run.config(), config.dump(2));

  TrainingLog log(run.log(), options.iterations, start.iteration);
  log.event("start", {{"iteration", start.iteration}, {"initialisation", source}});
  say(fmt::format("{} training frames, initialised from {}, on {}", config["train_frames"].dump(),
                  source, backend->name()));
  const int64_t end = request.stop_after
                          ? std::min(options.iterations, start.iteration + *request.stop_after)
                          : options.iterations;
  Trainer trainer(*backend, scene, options, std::move(start), log);
  StageLog stages(*backend);
  json scores = json::object();
  const auto save = [&] {
    save_checkpoint(run.checkpoint(), trainer.host_state(), options, config);
  };
  do {
    stages.run(trainer, next_pause(trainer.state().iteration, end, request));
    const int64_t i = trainer.state().iteration;
    const bool done = i >= end || interrupted();
    if (done || (request.checkpoint_every > 0 && i % request.checkpoint_every == 0)) save();
    if (!interrupted() && (trainer.state().finished ||
                           (request.evaluate_every > 0 && i % request.evaluate_every == 0)))
      scores = score(*backend, trainer, scene, log);
    if (done) break;
  } while (true);
  save_model(run.model(), trainer.host_model());
  json result = summary(trainer, scores, *backend);
  stages.add_to(result);
  result["model"] = run.model().string();
  log.event("end", result);
  return result;
}

}  // namespace tessera
