// What: load the scene, start or resume, train in stretches between checkpoints and evaluations,
//       write the run folder.
// Not: a step (recon4d/training/trainer.cpp).
#include "tools/session/train_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options_json.h"
#include "recon4d/reduction/model_reduction.h"
#include "recon4d/training/trainer.h"
#include "recon4d/training/validation.h"
#include "tools/session/backend_choice.h"
#include "tools/session/checkpoint_plan.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/machine.h"
#include "tools/session/run_folder.h"
#include "tools/session/run_lock.h"
#include "tools/session/scene_lock.h"
#include "tools/session/session_times.h"
#include "tools/session/train_start.h"
#include "tools/session/training_log.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Leaves a scoring pass.
struct Stopped {};

/// One training in its run folder, from the first look at the folder to the result.
class Session {
 public:
  Session(const TrainRequest& request, SessionObserver& observer)
      : request_(request),
        observer_(observer),
        limit_(request.time_limit, request.stopwatch),
        checkpoints_(request.checkpoint_every, request.stopwatch),
        run_{request.run},
        lock_(request.run, observer),
        scene_lock_(request.scene, SceneLock::Use::kRead),
        previous_(wall_.time(WallSplit::kLoad, [&] { return previous_state(request, run_); })) {
    run_.remove_leftovers();
    options_ = previous_ ? previous_->options : request.options;
    with_nodes_ = previous_ ? stored_with_nodes() : request.with_nodes;
    complete_size_limit();
    validate(options_);
  }

  json run() {
    prepare();
    train();
    return result();
  }

 private:
  /// A model within so many dB of the best needs frames by which that is told.
  void complete_size_limit() {
    constexpr double kShare = 0.1;
    if (options_.within_db == 0 || options_.validation_share > 0) return;
    options_.validation_share = kShare;
    observer_.on_message(fmt::format(
        "--within-db: a share of {} of the training frames become validation views", kShare));
  }

  void prepare() {
    wall_.time(WallSplit::kLoad, [&] {
      scene_ = load_training_scene(request_.scene, options_);
      for (const std::string& warning : training_warnings(scene_, options_)) warn(warning);
    });
    // before anything looks at the training split
    const int64_t aside =
        hold_out_validation(scene_, options_.validation_share, uint64_t(options_.seed));
    wall_.time(WallSplit::kInit, [&] {
      ChosenBackend chosen = choose_backend(request_.backend);
      backend_ = std::move(chosen.backend);
      choice_ = std::move(chosen.choice);
      if (choice_.leaves_cuda_unused()) observer_.on_cuda_unused(choice_.reason);
      if (!previous_ || options_.motion == Motion::kAuto) complete_scene();
      config_ = make_config(request_, {options_, with_nodes_}, scene_, backend_->name());
      // before the images decided on any
      config_["asked_options"] =
          previous_ ? provenance().value("asked_options", json()) : to_json(request_.options);
      if (previous_) check_frames();
      if (previous_ && previous_->options.motion == Motion::kAuto) previous_.reset();
      make_folder(run_.root);
      start();
    });
    if (aside > 0)
      observer_.on_message(fmt::format(
          "{} training frames are validation views, by which the model is chosen", aside));
    observer_.on_message(test_views_of(scene_).text());
  }

  /// What follows from the images alone.
  void complete_scene() {
    if (const auto found = complete_cloud(scene_, options_)) observer_.on_message(*found);
    for (const std::string& found : resolve_by_cloud(scene_, options_)) observer_.on_message(found);
    // refuses what cannot be learned before motion is tried
    exposure_rows(scene_, scene_.split_indices(Split::kTrain), options_);
    complete_motion();
  }

  /// Its trial takes a quarter of a time limit at most. Where the observer stops it, motion stays
  /// `auto`, the training takes no step, and a resumed one tries again.
  void complete_motion() {
    constexpr double kShare = 0.25;
    const double begin = request_.stopwatch(), last = begin + kShare * limit_.seconds();
    const auto say = [&](const std::string& line) { observer_.on_message(line); };
    const auto stop = [&] {
      left_ = left_ || observer_.must_stop();
      return left_ || request_.stopwatch() > last;
    };
    const bool known = resolve_motion(*backend_, scene_, with_nodes_, options_, stop, say);
    choice_seconds_ = request_.stopwatch() - begin;
    if (known || left_) return;
    options_.motion = Motion::kPair;
    say("motion: dynamic Gaussians, as --time-limit leaves too little time to try nodes; "
        "--motion nodes does otherwise");
  }

  /// Of a checkpoint whose training was stopped before it knew its motion.
  std::optional<TrainOptions> stored_with_nodes() const {
    const json stored = provenance();
    if (!stored.contains("with_nodes")) return std::nullopt;
    return train_options_from_json(stored["with_nodes"]);
  }

  /// config.json of the training that is resumed.
  json provenance() const { return json::parse(previous_->provenance); }

  void check_frames() const {
    if (provenance().value("scene_fingerprint", "") !=
        config_["scene_fingerprint"].get<std::string>())
      throw CheckpointRefused(
          fmt::format("{}: was trained on other frames than {} holds; resume with the "
                      "scene it was started on",
                      run_.checkpoint().string(), request_.scene.string()));
  }

  void start() {
    validation_.emplace(*backend_, scene_, options_,
                        previous_ ? previous_->validation : ValidationRecord{});
    kept_best_ = validation_->record().best_iteration;
    if (kept_best_ > 0) restore_best(run_.best(kept_best_));
    std::string source = "checkpoint";
    TrainState state =
        previous_ ? std::move(previous_->state) : initial_state(scene_, options_, source);
    if (!previous_) {
      state.seconds = choice_seconds_;  // training that the model needs
      replace_previous_run();
    }
    log_.emplace(run_.log(), options_.iterations, state.iteration, observer_);
    log_start(state.iteration, source);
    const std::string why = choice_.cuda ? "" : fmt::format(" ({})", choice_.reason);
    observer_.on_message(fmt::format("{} training frames, initialised from {}, on {}{}",
                                     config_["train_frames"].dump(), source, backend_->name(),
                                     why));
    end_ = request_.stop_after
               ? std::min(options_.iterations, state.iteration + *request_.stop_after)
               : options_.iterations;
    trainer_.emplace(*backend_, scene_, options_, std::move(state), *log_);
    reduction_.emplace(*backend_, options_, request_.shipped_bytes);
    stages_.emplace(*backend_);
    if (request_.snapshots != nullptr) request_.snapshots->begin(scene_, options_);
  }

  /// Who continues a training may do so on another machine: each start is recorded.
  void log_start(int64_t iteration, const std::string& source) {
    log_->event("start", {{"iteration", iteration},
                          {"initialisation", source},
                          {"command", command_line()},
                          {"time", utc_time()},
                          {"host", host_name()},
                          {"cpu", cpu_name()},
                          {"device", backend_->name()}});
    for (const std::string& warning : early_warnings_) log_->event("warning", {{"text", warning}});
    early_warnings_.clear();
  }

  /// To the observer and into the log, which begins after the first warnings.
  void warn(const std::string& warning) {
    observer_.on_warning(warning);
    if (log_)
      log_->event("warning", {{"text", warning}});
    else
      early_warnings_.push_back(warning);
  }

  /// A run that was here goes when there is something to put in its place, not before: a scene that
  /// cannot be read or a full disk costs nothing. config.json comes last, so that a checkpoint
  /// beside it is one of its training.
  void replace_previous_run() {
    AtomicFile config(run_.config());
    config.write(config_.dump(2));
    config.sync();
    run_.remove_files();
    config.commit();
  }

  void restore_best(const std::filesystem::path& file) {
    if (!std::filesystem::exists(file))
      throw CheckpointRefused(
          fmt::format("{}: is gone, the best model so far of this run; train again with "
                      "--overwrite",
                      file.string()));
    validation_->restore_best(load_model(file));
  }

  void train() {
    if (limit_.on()) save();  // says how long that takes, and there is something to go on from
    check_model();            // a run may have been stopped before it could
    decide();
    const int64_t first = trainer_->state().iteration;
    checkpoints_.begin(first);
    while (true) {
      if (!stops()) take_steps();
      if (!leaves()) check_model();
      if (!leaves()) decide();
      const int64_t i = trainer_->state().iteration;
      const bool done = i >= end_ || stops() || leaves();
      if (done || checkpoints_.due(i)) save();
      if (!leaves() && scores_at(i)) score(trainer_->host_model(), i, "evaluation", true);
      if (done) break;
    }
    if (ended() && validation_->on() && request_.evaluate_end && !leaves())
      score(model(), validation_->record().best_iteration, "shipped", false);
    write_model();
    if (left_ && !observer_.must_stop()) report_limit(first);
  }

  bool snapshot_due() const { return request_.snapshots != nullptr && request_.snapshots->due(); }

  void take_steps() {
    limit_.begin_steps();
    wall_.time(WallSplit::kTrain, [&] {
      stages_->count([&] {
        trainer_->run(next_pause(), [&] {
          return left_ || observer_.must_stop() || checkpoints_.due(trainer_->state().iteration) ||
                 snapshot_due() || limit_.due_after_step(trainer_->state().model.count());
        });
        if (snapshot_due()) request_.snapshots->take(trainer_->state());
      });
    });
  }

  /// Whether it is time to save and go, by a signal or by the clock; once yes, always yes.
  bool leaves() {
    left_ = left_ || observer_.must_stop() || limit_.due(trainer_->state().model.count());
    return left_;
  }

  /// A limit that every call reaches before its first step would be resumed for ever.
  void report_limit(int64_t first) const {
    const int64_t i = trainer_->state().iteration;
    if (i == first && !ended())
      throw InputError(fmt::format(
          "--time-limit: {:.0f} s leave room for no step beside loading and saving, which have "
          "taken {:.1f} s; pass a longer one",
          limit_.seconds(), request_.stopwatch()));
    observer_.on_message(fmt::format("time limit: leaves at step {} of {}; --resume goes on", i,
                                     options_.iterations));
  }

  void write_model() {
    if (model().count() == 0)
      warn(
          "no Gaussians are left, density control has removed them all: images are the "
          "background; look at the poses (tessera doctor) and at --init-extent");
    wall_.time(WallSplit::kSave, [&] { save_model(run_.model(), model()); });
    if (trainer_->state().exposure.rows() > 0)
      write_text_file(
          run_.exposure(),
          exposure_json(trainer_->exposed(), trainer_->state().exposure, options_).dump(2));
  }

  /// Where training pauses next: the end, a checkpoint, an evaluation, a check, a stop asked for.
  int64_t next_pause() const {
    const int64_t i = trainer_->state().iteration;
    int64_t next = std::min(end_, checkpoints_.next_after(i));
    if (request_.evaluate_every > 0)
      next = std::min(next, (i / request_.evaluate_every + 1) * request_.evaluate_every);
    for (int64_t step : request_.evaluate_at)
      if (step > i) next = std::min(next, step);
    next = std::min(next, reduction_->schedule().next_after(i));
    return validation_->on() ? std::min(next, validation_->next_after(i)) : next;
  }

  /// Whether the model is scored on the held-out splits after so many steps.
  bool scores_at(int64_t i) const {
    const std::vector<int64_t>& steps = request_.evaluate_at;
    return (ended() && !validation_->on() && request_.evaluate_end) ||
           (request_.evaluate_every > 0 && i % request_.evaluate_every == 0) ||
           std::find(steps.begin(), steps.end(), i) != steps.end();
  }

  /// Patience has run out with a model of the size that is asked for.
  bool stops() const {
    return validation_->stops() && reduction_->schedule().has_pruned(trainer_->state().decided);
  }
  bool ended() const { return trainer_->state().finished || stops(); }

  /// What leaves the program: the best model by validation, else the last; in the end of the size
  /// that was asked for.
  const GaussianModel& model() {
    if (shipped_) return *shipped_;
    const bool fits = prunes_after_growth(options_) && ended() && !left_;
    if (validation_->best() == nullptr && !fits) return trainer_->host_model();
    GaussianModel best = validation_->best() != nullptr ? validation_->shipped()
                                                        : trainer_->host_model().clone_values();
    if (fits)
      best = wall_.time(WallSplit::kEvaluate, [&] {
        return fit_to_limit(size_limit(), *backend_, best, trainer_->sample_frames());
      });
    shipped_ = std::move(best);
    return *shipped_;
  }

  SizeLimit size_limit() {
    SizeLimit limit;
    limit.gaussians = options_.max_gaussians;
    limit.bytes = options_.max_bytes;
    limit.shipped_bytes = request_.shipped_bytes;
    if (options_.within_db > 0)
      limit.least_psnr = validation_->record().peak_psnr - options_.within_db;
    limit.psnr = [this](const GaussianModel& m) { return validation_->psnr(m); };
    return limit;
  }

  void check_model() {
    const TrainState& state = trainer_->state();
    if (!validation_->due(state.iteration)) return;
    limit_.whole([&] {
      wall_.time(WallSplit::kEvaluate, [&] {
        validation_->check(trainer_->drawn_model(), state.iteration, state.seconds);
      });
    });
    const ValidationRecord& record = validation_->record();
    log_->event("validation", {{"iteration", state.iteration},
                               {"seconds", state.seconds},
                               {"num_gaussians", state.model.count()},
                               {"psnr", record.last_psnr},
                               {"best_psnr", record.best_psnr},
                               {"best_iteration", record.best_iteration},
                               {"without_gain", record.without_gain}});
  }

  /// Thins out and moves between the sets where that is due.
  void decide() {
    std::optional<ReductionReport> report;
    limit_.whole([&] {
      wall_.time(WallSplit::kTrain, [&] {
        stages_->count([&] { report = reduction_->act(*trainer_, validation_->record()); });
      });
    });
    if (!report) return;
    // models so far were larger than what may be shipped; within_db compares them by size
    if (report->goal > 0 && reduction_->schedule().has_pruned(report->iteration) &&
        options_.within_db == 0)
      validation_->restart();
    log_->event("decision", to_json(*report));
  }

  void save() {
    checkpoints_.save(trainer_->state().iteration, [&] {
      limit_.save(trainer_->state().model.count(),
                  [&] { wall_.time(WallSplit::kSave, [&] { write_checkpoint(); }); });
    });
  }

  /// The best model before the checkpoint that names it; older ones after it.
  void write_checkpoint() {
    const int64_t best = validation_->record().best_iteration;
    if (validation_->best() != nullptr && best != kept_best_) {
      save_model(run_.best(best), *validation_->best());
      kept_best_ = best;
    }
    save_checkpoint(run_.checkpoint(), trainer_->host_state(), options_, config_.dump(),
                    validation_->record());
    run_.remove_best_but(best);
  }

  /// `brief`: PSNR and SSIM alone.
  void score(const GaussianModel& scored, int64_t iteration, const std::string& event, bool brief) {
    try {
      wall_.time(WallSplit::kEvaluate, [&] {
        scores_ = score_splits(
            *backend_, scored, scene_, held_out_splits(scene_), std::nullopt,
            [&](const Frame&, const RenderedImage&, const ViewScore&, int64_t, int64_t) {
              if (observer_.must_stop() || limit_.over()) throw Stopped();
            },
            brief ? brief_scores() : EvaluateOptions{});
      });
    } catch (const Stopped&) {  // the checkpoint is written; a resumed run scores again
      left_ = true;
      return;
    }
    json summary = json::object();
    if (scores_.contains("splits"))
      for (const auto& [split, of_split] : scores_["splits"].items())
        summary[split] = {{"psnr", of_split["psnr"]}, {"ssim", of_split["ssim"]}};
    for (const auto& [split, of_split] : summary.items())
      observer_.on_message(fmt::format("step {}: {}: PSNR {} dB, {} Gaussians", iteration,
                                       views_text(split), number_text(of_split["psnr"], 2),
                                       scored.count()));
    log_->event(event, {{"iteration", iteration},
                        {"seconds", trainer_->state().seconds},
                        {"num_gaussians", scored.count()},
                        {"splits", summary}});
  }

  /// Null without validation.
  json validation_result() const {
    if (!validation_->on()) return nullptr;
    json result = to_json(validation_->record());
    const TrainState& state = trainer_->state();
    result["frames"] = validation_->frames();
    result["stop_iteration"] = state.iteration;
    result["stop_seconds"] = state.seconds;
    return result;
  }

  /// Null without gains.
  json exposure_result() const {
    const std::vector<ColourMap<double>> maps = colour_maps_of(trainer_->state().exposure);
    if (maps.empty()) return nullptr;
    Vec3<double> least = channel_response(maps.front()), most = least;
    for (const ColourMap<double>& map : maps) {
      const Vec3<double> gain = channel_response(map);
      least = glm::min(least, gain);
      most = glm::max(most, gain);
    }
    return {{"by", name_of(options_.exposure)},
            {"count", maps.size()},
            {"smallest", {least[0], least[1], least[2]}},
            {"largest", {most[0], most[1], most[2]}},
            {"file", run_.exposure().string()}};
  }

  json result() {
    const TrainState& state = trainer_->state();
    const GaussianModel& shipped = model();
    json result = {{"seconds", state.seconds},
                   {"iterations", state.iteration},
                   {"total_iterations", options_.iterations},
                   {"finished", ended() && !left_},
                   {"left", left_},
                   {"num_gaussians", shipped.count()},
                   {"num_static", shipped.static_set.count()},
                   {"num_dynamic", shipped.dynamic_set.count()},
                   {"device", backend_->name()},
                   {"backend", choice_.kind()},
                   {"backend_reason", choice_.reason},
                   {"wall_seconds", wall_.json()},
                   {"validation", validation_result()},
                   {"exposure", exposure_result()},
                   {"scores", scores_}};
    stages_->add_to(result);
    result["model"] = run_.model().string();
    result["bytes"] = std::filesystem::file_size(run_.model());
    log_->event("end", result);
    return result;
  }

  const TrainRequest& request_;
  SessionObserver& observer_;
  WallSplit wall_;
  TimeLimit limit_;
  CheckpointPlan checkpoints_;
  const RunFolder run_;
  const RunLock lock_;
  const SceneLock scene_lock_;
  std::optional<Checkpoint> previous_;
  TrainOptions options_;
  std::optional<TrainOptions> with_nodes_;
  Scene scene_;
  DeviceChoice choice_;
  std::unique_ptr<Backend> backend_;
  json config_, scores_ = json::object();
  std::vector<std::string> early_warnings_;  // before there is a log
  int64_t end_ = 0;                          // of this call, steps
  double choice_seconds_ = 0;                // of the trials of motion
  std::optional<TrainingLog> log_;
  std::optional<Trainer> trainer_;
  std::optional<StageLog> stages_;
  std::optional<Validation> validation_;
  std::optional<ModelReduction> reduction_;
  std::optional<GaussianModel> shipped_;
  bool left_ = false;      // before the end, to be resumed
  int64_t kept_best_ = 0;  // step of the best model whose file this run has written or read
};

}  // namespace

json train_session(const TrainRequest& request, SessionObserver& observer) {
  return Session(request, observer).run();
}

json train_or_restart(TrainRequest request, SessionObserver& observer) {
  if (!request.resume) return train_session(request, observer);
  try {
    return train_session(request, observer);
  } catch (const CheckpointRefused& error) {
    const std::filesystem::path aside = RunFolder{request.run}.set_checkpoint_aside();
    observer.on_warning(fmt::format("{}; it is {} now, and the training starts anew", error.what(),
                                    aside.string()));
    request.resume = false;
    return train_session(request, observer);
  }
}

}  // namespace tessera
