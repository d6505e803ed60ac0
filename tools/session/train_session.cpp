// One training in its run folder: an event after the other, as session_events.h orders them.
#include "tools/session/train_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/reduction/model_reduction.h"
#include "recon4d/training/trainer.h"
#include "tools/session/clock/session_events.h"
#include "tools/session/device_choice.h"
#include "tools/session/locks.h"
#include "tools/session/run_writer.h"
#include "tools/session/session_results.h"
#include "tools/session/training_setup.h"

namespace tessera {
namespace {

using nlohmann::json;

class Session {
 public:
  Session(const TrainRequest& request, SessionObserver& observer)
      : request_(request),
        observer_(observer),
        limit_(request.time_limit, request.stopwatch),
        checkpoints_(request.checkpoint_every, request.stopwatch),
        evaluations_(request.evaluate_every),
        lock_(request.run, observer),
        scene_lock_(request.scene, SceneLock::Use::kRead),
        writer_(request.run, observer) {}

  json run() {
    set_up();
    train();
    return result();
  }

 private:
  void set_up() {
    const RunFolder& run = writer_.folder();
    setup_ = wall_.time(WallSplit::kLoad, [&] { return previous_setup(request_, run, observer_); });
    remove_partial_files(run.root);
    complete_setup(setup_, request_, run, limit_.seconds(), wall_, observer_,
                   [&](const std::string& warning) { writer_.warn(warning); });
    left_ = setup_.stopped;
    wall_.time(WallSplit::kInit, [&] { start(); });
    if (setup_.validation_views > 0)
      observer_.on_message(
          fmt::format("{} training frames are validation views, by which the model is chosen",
                      setup_.validation_views));
    observer_.on_message(test_views_of(setup_.scene).text());
  }

  void start() {
    Backend& backend = *setup_.backend;
    std::optional<Checkpoint>& previous = setup_.previous;
    make_folder(writer_.folder().root);
    validation_.emplace(backend, setup_.scene, options(),
                        previous ? previous->validation : ValidationRecord{});
    if (const int64_t best = validation_->record().best_iteration; best > 0)
      validation_->restore_best(writer_.read_best(best));
    std::string source = "checkpoint";
    TrainState state = previous ? std::move(previous->state) : first_state(source);
    if (!previous) {
      state.seconds = setup_.motion_seconds;  // training that the model needs
      writer_.replace_previous_run(setup_.config);
    }
    // who continues a training may do so on another machine
    TrainingLog& log = writer_.begin_log(options().iterations, state.iteration,
                                         {{"iteration", state.iteration},
                                          {"initialisation", source},
                                          {"command", command_line()},
                                          {"time", utc_time()},
                                          {"host", host_name()},
                                          {"cpu", cpu_name()},
                                          {"device", backend.name()}});
    const std::string why = setup_.choice.cuda ? "" : fmt::format(" ({})", setup_.choice.reason);
    observer_.on_message(fmt::format("{} training frames, initialised from {}, on {}{}",
                                     setup_.config["train_frames"].dump(), source, backend.name(),
                                     why));
    if (state.finished)
      observer_.on_message(
          fmt::format("{}: finished at step {} of {}, so that nothing is left to do; --resume "
                      "--iterations N trains on until step N",
                      request_.run.string(), state.iteration, options().iterations));
    first_ = state_.step = state.iteration;
    state_.end = request_.stop_after ? std::min(options().iterations, first_ + *request_.stop_after)
                                     : options().iterations;
    trainer_.emplace(backend, setup_.scene, options(), std::move(state), log);
    reduction_.emplace(backend, options(), request_.shipped_bytes);
    stages_.emplace(backend);
    if (request_.snapshots != nullptr) request_.snapshots->begin(setup_.scene, options());
  }

  TrainState first_state(std::string& source) const {
    const std::optional<StaticModel>& shared = setup_.shared;
    if (!shared) return initial_state(setup_.scene, options(), source);
    TrainState state = initial_state(setup_.scene, options(), source, &shared->model.static_set);
    if (state.exposure.rows() > 0)
      state.exposure = shared_exposure(*shared, setup_.scene, options());
    return state;
  }

  void train() {
    checkpoints_.begin(first_);
    if (limit_.on()) act(SessionEvent::kSave);  // measures a save, and there is one to resume from
    while (true) {
      refresh();
      const SessionEvent event = next_event(state_);
      if (event == SessionEvent::kEnd) break;
      act(event);
    }
    if (evaluations_.at_end() && ended() && validation_->on() && !leaves())
      score(model(), validation_->record().best_iteration, "shipped", true);
    wall_.time(WallSplit::kSave, [&] { write_results(); });
    if (left_ && !observer_.must_stop()) report_limit();
  }

  void refresh() {
    const int64_t step = state_.step = trainer_->state().iteration;
    state_.leaves = leaves();
    state_.stops = stops();
    state_.check_due = validation_->due(step);
    state_.save_due = checkpoints_.due(step);
    const auto is_new = [&] {
      return step > first_ || (step > 0 && !was_scored(writer_.folder().log(), step));
    };
    state_.score_due = (evaluations_.due(step) && is_new()) ||
                       (evaluations_.at_end() && ended() && !validation_->on());
  }

  void act(SessionEvent event) {
    switch (event) {
      case SessionEvent::kTrain:
        take_steps();
        break;
      case SessionEvent::kCheck:
        check_model();
        break;
      case SessionEvent::kDecide:
        decide();
        break;
      case SessionEvent::kSave:
        save();
        break;
      case SessionEvent::kScore:
        score(trainer_->host_model(), state_.step, "evaluation", false);
        break;
      case SessionEvent::kEnd:
        break;
    }
    state_.did(event);
  }

  const TrainOptions& options() const { return setup_.options; }
  /// Patience has run out with a model of the size that is asked for.
  bool stops() const {
    return validation_->stops() && reduction_->schedule().has_pruned(trainer_->state().decided);
  }
  bool ended() const { return trainer_->state().finished || stops(); }
  /// Whether it is time to save and go, by a signal or by the clock; once yes, always yes.
  bool leaves() {
    left_ = left_ || observer_.must_stop() || limit_.due(trainer_->state().model.count());
    return left_;
  }
  bool snapshot_due() const { return request_.snapshots != nullptr && request_.snapshots->due(); }

  /// Where training pauses next: the end, a checkpoint, an evaluation, a check, a decision.
  int64_t next_pause() const {
    const int64_t step = state_.step;
    return std::min({state_.end, checkpoints_.next_after(step), evaluations_.next_after(step),
                     reduction_->schedule().next_after(step),
                     validation_->on() ? validation_->next_after(step) : state_.end});
  }

  void take_steps() {
    limit_.begin_steps();
    const double unseen = trainer_->unseen_seconds();
    wall_.time(WallSplit::kSteps, [&] {
      stages_->count([&] {
        trainer_->run(next_pause(), [&] {
          return left_ || observer_.must_stop() || checkpoints_.due(trainer_->state().iteration) ||
                 snapshot_due() || limit_.due_after_step(trainer_->state().model.count());
        });
        if (snapshot_due()) request_.snapshots->take(trainer_->state());
      });
    });
    wall_.move(WallSplit::kSteps, WallSplit::kUnseen, trainer_->unseen_seconds() - unseen);
  }

  void check_model() {
    const TrainState& state = trainer_->state();
    limit_.whole([&] {
      wall_.time(WallSplit::kEvaluate, [&] {
        validation_->check(trainer_->drawn_model(), state.iteration, state.seconds);
      });
    });
    const ValidationRecord& record = validation_->record();
    writer_.log().event("validation", {{"iteration", state.iteration},
                                       {"seconds", state.seconds},
                                       {"num_gaussians", state.model.count()},
                                       {"psnr", record.last_psnr},
                                       {"best_psnr", record.best_psnr},
                                       {"best_iteration", record.best_iteration},
                                       {"without_gain", record.without_gain}});
  }

  /// Prunes and moves Gaussians between the sets where that is due.
  void decide() {
    std::optional<ReductionReport> report;
    limit_.whole([&] {
      wall_.time(WallSplit::kDecide, [&] {
        stages_->count([&] { report = reduction_->act(*trainer_, validation_->record()); });
      });
    });
    if (!report) return;
    // models so far were larger than what may be shipped; within_db compares them by size
    if (report->goal > 0 && reduction_->schedule().has_pruned(report->iteration) &&
        options().within_db == 0)
      validation_->restart();
    writer_.log().event("decision", to_json(*report));
  }

  void save() {
    checkpoints_.save(trainer_->state().iteration, [&] {
      limit_.save(trainer_->state().model.count(), [&] {
        wall_.time(WallSplit::kSave, [&] {
          writer_.write_checkpoint(trainer_->host_state(), options(), setup_.config, *validation_);
        });
      });
    });
  }

  /// Where it is stopped, the session leaves, and a resumed one scores again: was_scored.
  void score(const GaussianModel& model, int64_t step, const std::string& event, bool is_complete) {
    const ScoredModel scored{model, step, trainer_->state().seconds, event, is_complete};
    const auto stop = [&] { return observer_.must_stop() || limit_.over(); };
    wall_.time(WallSplit::kEvaluate, [&] {
      left_ =
          !scores_.score(*setup_.backend, setup_.scene, scored, stop, writer_.log(), observer_) ||
          left_;
    });
  }

  const GaussianModel& model() {
    if (!shipped_)
      wall_.time(WallSplit::kEvaluate, [&] {
        shipped_ = shipped_model(*trainer_, options(), *validation_, *setup_.backend,
                                 request_.shipped_bytes, ended() && !left_);
      });
    return shipped_ ? *shipped_ : trainer_->host_model();
  }

  void write_results() {
    if (trainer_->state().iteration > first_) {  // scores are those of another model then
      std::error_code ignored;
      std::filesystem::remove(writer_.folder().metrics(), ignored);
    }
    writer_.write_model(model());
    const LearntRows& exposure = trainer_->state().exposure;
    if (exposure.rows() > 0)
      write_text_file(writer_.folder().exposure(),
                      json_text(exposure_json(trainer_->exposed(), exposure, options()), 2));
  }

  /// A limit that every call reaches before its first step would be resumed for ever.
  void report_limit() const {
    const int64_t step = trainer_->state().iteration;
    if (step == first_ && !ended())
      throw InputError(fmt::format(
          "--time-limit: {:.0f} s leave room for no step beside loading and saving, which have "
          "taken {:.1f} s; pass a longer one",
          limit_.seconds(), request_.stopwatch()));
    observer_.on_message(fmt::format("time limit: leaves at step {} of {}; --resume goes on", step,
                                     options().iterations));
  }

  json result() {
    json result = training_result(trainer_->state(), options(), *validation_, model());
    result["finished"] = ended() && !left_;
    result["left"] = left_;
    result["device"] = setup_.backend->name();
    result["backend"] = setup_.choice.kind();
    result["backend_reason"] = setup_.choice.reason;
    result["wall_seconds"] = wall_.json();
    result["scores"] = scores_.last();
    stages_->add_to(result);
    const RunFolder& run = writer_.folder();
    if (!result["exposure"].is_null()) result["exposure"]["file"] = run.exposure().string();
    result.update(clocks_json(trainer_->clocked(), trainer_->state().clocks,
                              setup_.scene.time_axis.duration));
    result["model"] = run.model().string();
    result["bytes"] = std::filesystem::file_size(run.model());
    writer_.log().event("end", result);
    return result;
  }

  const TrainRequest& request_;
  SessionObserver& observer_;
  WallSplit wall_;
  TimeLimit limit_;
  CheckpointPlan checkpoints_;
  const EvaluationPlan evaluations_;
  const RunLock lock_;
  const SceneLock scene_lock_;
  RunWriter writer_;
  TrainingSetup setup_;
  SessionState state_;
  int64_t first_ = 0;  // steps before this call
  std::optional<Trainer> trainer_;
  std::optional<StageLog> stages_;
  std::optional<Validation> validation_;
  std::optional<ModelReduction> reduction_;
  std::optional<GaussianModel> shipped_;
  SessionScores scores_;
  bool left_ = false;  // before the end, to be resumed
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
    observer.on_warning(fmt::format("{}; the training starts anew", error.what()));
    RunLock(request.run, observer).make_room();
    request.resume = false;
    return train_session(request, observer);
  }
}

}  // namespace tessera
