// One decision after another: each measures the model as it is, chooses, and applies one edit.
// Demotion and pruning measure again after partial edits, because what hides behind a Gaussian is
// seen only when it is gone.
#include "recon4d/reduction/model_reduction.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "kernels/base/seconds_since.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/reduction/dynamic_promotion.h"
#include "recon4d/reduction/motion_choice.h"
#include "recon4d/reduction/spawn_missed.h"
#include "recon4d/reduction/static_demotion.h"

namespace tessera {
namespace {

bool has_timesteps(const FrameSample& sample) {
  for (int64_t i = 1; i < sample.count(); ++i)
    if (sample.frame(i).timestep != sample.frame(0).timestep) return true;
  return false;
}

/// What is static and what is dynamic from now on.
struct MotionDecision {
  double error_per_byte = 0;  // squared error per byte at the knee
  double demotion_error = 0;  // squared error that demotion adds
  int64_t spawned = 0;        // Gaussians
  StateEdit edit;             // drops what changes its set, adds it to the other
};

/// `contributions`: of `model`, the drawn one. A trial draws `sample`.
MotionDecision decide_motion(Backend& backend, const GaussianModel& model,
                             const Contributions& contributions, const FrameSample& sample,
                             const DueDecision& due) {
  const MotionPrices prices =
      motion_prices(removal_order(model, contributions), contributions, model.drawing.sh_degree);
  PromotionChoice choice = choose_promotion(contributions, prices, model.count(), due.promote);
  MotionDecision decision{prices.error_per_byte, 0, int64_t(choice.spawned.size()), {}};
  StateEdit& edit = decision.edit;
  if (due.demote) {
    DemotionTrial trial =
        try_demotion(backend, model, contributions, sample, prices.allowed_demotion);
    decision.demotion_error = trial.error;
    edit.added[0].push_back(std::move(trial.demoted));
    edit.dropped[1] = std::move(trial.elements);
  }
  edit.added[1].push_back(as_dynamic(backend, model, contributions, choice.promoted));
  edit.added[1].push_back(spawn_dynamic(backend, model, contributions, choice.spawned));
  edit.dropped[0] = std::move(choice.promoted);
  return decision;
}

/// `contributions`: of `model`, the stored one, whose elements may differ in their SH degree.
/// `first`: the first set whose degrees are chosen.
StateEdit decide_colour(const GaussianModel& model, const Contributions& contributions,
                        double error_per_byte, int first) {
  StateEdit edit;
  for (int k = first; k < 2; ++k)
    edit.degrees[k] =
        choose_degrees(sh_degrees(k == 0 ? model.static_set : model.dynamic_set),
                       contributions.sets[k], k == 1, model.drawing.sh_degree, error_per_byte);
  return edit;
}

void report_pass(const Contributions& contributions, const FrameSample& sample,
                 ReductionReport& report) {
  report.sampled_frames = std::llround(contributions.share * double(sample.count()));
  report.psnr = contributions.psnr_after(0);
}

void report_motion(const MotionDecision& decision, ReductionReport& report) {
  report.error_per_byte = decision.error_per_byte;
  report.demotion_error = decision.demotion_error;
  report.demoted = int64_t(decision.edit.dropped[1].size());
  report.promoted = int64_t(decision.edit.dropped[0].size());
  report.spawned = decision.spawned;
}

void report_pruning(const PruningChoice& choice, int64_t before, ReductionReport& report) {
  report.knee = choice.knee;
  report.error_per_byte = choice.error_per_byte;
  report.goal = choice.goal;
  report.removed += before - choice.after;
}

void report_colour(const StateEdit& edit, ReductionReport& report) {
  for (const std::vector<uint8_t>& degrees : edit.degrees)
    for (const uint8_t degree : degrees) ++report.degrees[degree];
}

/// One decision, edit by edit: each is of what was measured since the last one.
class OneDecision {
 public:
  OneDecision(Backend& backend, const TrainOptions& options, const DueDecision& due,
              Trainer& trainer)
      : backend_(backend), options_(options), due_(due), trainer_(trainer) {
    trainer.release_step_buffers();
    sample_ = trainer.sample_frames();
    report_.iteration = due.iteration;
    report_.static_before = state_.model.static_set.count();
    report_.dynamic_before = state_.model.dynamic_set.count();
  }

  /// Which Gaussians are static and which dynamic; new ones where pixels that move are missed.
  void change_motion() {
    if (!has_timesteps(sample_)) return;
    report_pass(measured(), sample_, report_);
    MotionDecision decision;
    if (is_frozen()) {
      decision.edit.dropped[1] = still_dynamic(measured());
      report_.removed += int64_t(decision.edit.dropped[1].size());
    } else {
      decision = decide_motion(backend_, trainer_.drawn_model(), measured(), sample_, due_);
      report_motion(decision, report_);
    }
    if (due_.spawn_missed) {
      GaussianSet spawned =
          spawn_missed(backend_, trainer_.drawn_model(), sample_, uint64_t(options_.seed));
      report_.spawned_missed = spawned.count();
      if (spawned.count() > 0) decision.edit.added[1].push_back(std::move(spawned));
    }
    if (!decision.edit.empty()) apply(decision.edit);
  }

  /// Removes what costs least; in the last round, then, SH degrees.
  void prune(SizeRequest request, const ShippedBytes& bytes) {
    report_pass(measured(), sample_, report_);
    std::vector<Removal> order = this->order();
    if (is_frozen() && request.gaussians > 0)
      request.gaussians = std::max<int64_t>(1, request.gaussians - state_.model.static_set.count());
    if (request.bytes > 0 && request.known_goal == 0 && !order.empty())
      request.file_bytes = bytes(trainer_.host_model());
    const PruningChoice choice = choose_pruning(order, measured(), request);
    const int64_t seen = seen_count(order);
    report_pruning(choice, seen, report_);
    for (int64_t now = seen; now > choice.after; order = this->order()) {
      now = next_cut(now, choice.after);
      apply(cut_to(order, now));
    }
    if (order.empty()) return;
    report_.psnr_after = measured().psnr_after(0);
    if (!options_.decide_colour || due_.rounds_left != 1) return;
    const StateEdit edit =
        decide_colour(state_.model, measured(), choice.error_per_byte, is_frozen() ? 1 : 0);
    report_colour(edit, report_);
    apply(edit);
  }

  /// `seconds`: of all of it.
  ReductionReport finished(double seconds) {
    report_.static_after = state_.model.static_set.count();
    report_.dynamic_after = state_.model.dynamic_set.count();
    report_.seconds = seconds;
    trainer_.record(report_.goal > 0 ? report_.goal : state_.goal, seconds);
    return report_;
  }

 private:
  /// Whether the static set is that of a whole clip, of which this is a window.
  bool is_frozen() const { return !state_.trains(0); }
  /// What each Gaussian contributes, of the model as it is.
  const Contributions& measured() {
    if (!contributions_)
      contributions_ =
          measure_contributions(backend_, trainer_.drawn_model(), sample_, kSampledFrames);
    return *contributions_;
  }
  std::vector<Removal> order() { return removal_order(state_.model, measured(), is_frozen()); }
  void apply(const StateEdit& edit) {
    trainer_.apply(edit);
    contributions_.reset();
  }

  Backend& backend_;
  const TrainOptions& options_;
  const DueDecision& due_;
  Trainer& trainer_;
  const TrainState& state_ = trainer_.state();
  FrameSample sample_;
  std::optional<Contributions> contributions_;
  ReductionReport report_;
};

}  // namespace

ModelReduction::ModelReduction(Backend& backend, const TrainOptions& options, ShippedBytes bytes)
    : backend_(backend), options_(options), schedule_(options), bytes_(std::move(bytes)) {}

SizeRequest ModelReduction::size_request(const ValidationRecord& validation, int64_t known_goal,
                                         int64_t rounds_left) const {
  SizeRequest request;
  request.gaussians = options_.max_gaussians;
  request.bytes = options_.max_bytes;
  request.within_db = options_.within_db;
  request.validation_room = options_.within_db;
  if (validation.checks > 0) request.validation_room -= validation.peak_psnr - validation.last_psnr;
  // The knee is that of the first round. Other goals are found anew by each round.
  if (options_.size == ModelSize::kKnee && options_.within_db == 0) request.known_goal = known_goal;
  request.rounds_left = rounds_left;
  return request;
}

std::optional<ReductionReport> ModelReduction::act(Trainer& trainer,
                                                   const ValidationRecord& validation) {
  const TrainState& state = trainer.state();
  const DueDecision due = schedule_.due(state.iteration, state.decided);
  if (!due.any()) return std::nullopt;
  const auto begin = std::chrono::steady_clock::now();
  OneDecision decision(backend_, options_, due, trainer);
  if (due.motion) decision.change_motion();
  if (due.prune) decision.prune(size_request(validation, state.goal, due.rounds_left), bytes_);
  return decision.finished(seconds_since(begin));
}

nlohmann::json to_json(const ReductionReport& report) {
  return {{"iteration", report.iteration},
          {"sampled_frames", report.sampled_frames},
          {"static_before", report.static_before},
          {"dynamic_before", report.dynamic_before},
          {"static", report.static_after},
          {"dynamic", report.dynamic_after},
          {"knee", report.knee},
          {"goal", report.goal},
          {"removed", report.removed},
          {"demoted", report.demoted},
          {"promoted", report.promoted},
          {"spawned", report.spawned},
          {"spawned_missed", report.spawned_missed},
          {"price", report.error_per_byte},
          {"demotion_error", report.demotion_error},
          {"psnr", report.psnr},
          {"thinned", report.psnr_after},
          {"degrees", report.degrees},
          {"decision_seconds", report.seconds}};
}

}  // namespace tessera
