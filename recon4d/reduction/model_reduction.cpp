// What: the steps of decisions, what is to be left, and elements moved between the sets.
// Not: any arithmetic on images.
#include "recon4d/reduction/model_reduction.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "recon4d/model/sh_blocks.h"
#include "recon4d/reduction/dynamic_promotion.h"
#include "recon4d/reduction/pruning.h"
#include "recon4d/reduction/static_demotion.h"

namespace tessera {
namespace {

/// What is left over the goal for the exact cut in the end: some die during recovery.
constexpr double kSpare = 1.04;

bool contains(const std::vector<int64_t>& sorted, int64_t value) {
  return std::binary_search(sorted.begin(), sorted.end(), value);
}

/// More than one.
bool has_timesteps(const FrameSample& sample) {
  for (int64_t i = 1; i < sample.count(); ++i)
    if (sample.frame(i).time != sample.frame(0).time) return true;
  return false;
}

/// Between static and dynamic; what motion nodes carry stays as it is.
bool decides_motion(const TrainOptions& options) {
  return options.decide_motion && options.motion != Motion::kNone &&
         options.motion != Motion::kNodes;
}

/// Adds Gaussians that lie where the backend works to set k, without optimizer state or statistics.
void add_elements(Backend& backend, TrainState& state, int k, const GaussianSet& added) {
  SetStatistics statistics(backend.memory());
  statistics.reset(backend, added.count());
  append_elements(backend, added, statistics, state.set(k), state.statistics[k]);
}

/// Elements of set k go, ascending, with their optimizer state and statistics.
void drop_elements(Backend& backend, TrainState& state, int k,
                   const std::vector<int64_t>& elements) {
  keep_elements(backend, elements_but(state.set(k).count(), elements), state.set(k),
                state.statistics[k]);
}

}  // namespace

ModelReduction::ModelReduction(Backend& backend, const TrainOptions& options, ShippedBytes bytes)
    : backend_(backend), options_(options), bytes_(std::move(bytes)) {
  const int64_t grown = scaled_steps(options, options.densify_until) + 1;
  const int64_t last = std::max(grown, scaled_steps(options, options.thin_until));
  if (tessera::prunes_after_growth(options))
    for (int64_t r = 0; r < options.thin_rounds; ++r)
      rounds_.push_back(grown + (last - grown) * r / std::max<int64_t>(1, options.thin_rounds - 1));
  rounds_.erase(std::unique(rounds_.begin(), rounds_.end()), rounds_.end());
  std::erase_if(rounds_, [&](int64_t i) { return i >= options.iterations; });
  const int64_t interval = std::max<int64_t>(1, scaled_steps(options, options.decide_interval));
  if (tessera::decides_motion(options))
    for (int64_t i = interval; i < std::min(grown, options.iterations); i += interval)
      motion_.push_back(i);
}

int64_t ModelReduction::next_after(int64_t iteration) const {
  int64_t next = std::numeric_limits<int64_t>::max();
  for (const std::vector<int64_t>* steps : {&rounds_, &motion_})
    for (const int64_t i : *steps)
      if (i > iteration) next = std::min(next, i);
  return next;
}

int64_t ModelReduction::rounds_left(int64_t i) const {
  return contains(rounds_, i)
             ? std::count_if(rounds_.begin(), rounds_.end(), [i](int64_t r) { return r >= i; })
             : 0;
}

bool ModelReduction::decides_motion(int64_t i) const {
  return contains(motion_, i) || (tessera::decides_motion(options_) && contains(rounds_, i));
}

bool ModelReduction::has_pruned(int64_t iteration) const {
  return rounds_.empty() || iteration >= rounds_.back();
}

int64_t ModelReduction::goal_of(Trainer& trainer, const std::vector<Removal>& order,
                                const Contributions& contributions,
                                const ValidationRecord& validation, int64_t knee) const {
  if (options_.max_gaussians > 0) return int64_t(kSpare * double(options_.max_gaussians));
  if (options_.within_db > 0) {
    // what the validation frames have left of it; recovery makes good for most of what this
    // predicts
    double room = options_.within_db;
    if (validation.checks > 0) room -= validation.peak_psnr - validation.last_psnr;
    double error = 0;
    int64_t gone = 0;
    for (; gone + 1 < int64_t(order.size()) && order[size_t(gone)].seen; ++gone) {
      error += order[size_t(gone)].error;
      if (contributions.psnr_after(0) - contributions.psnr_after(error) > room) break;
    }
    return int64_t(order.size()) - gone;
  }
  if (options_.max_bytes == 0) return knee;
  double all = 0;
  for (const Removal& removal : order) all += removal.bytes;
  const double scale =
      double(bytes_(trainer.host_model())) / std::max(1.0, all);  // of our rates to the file
  double left = all * scale;
  int64_t gone = 0;
  while (gone < int64_t(order.size()) && left > kSpare * double(options_.max_bytes))
    left -= scale * order[size_t(gone++)].bytes;
  return int64_t(order.size()) - gone;
}

std::optional<ReductionReport> ModelReduction::act(Trainer& trainer,
                                                   const ValidationRecord& validation) {
  const int64_t i = trainer.state().iteration;
  const bool thins = rounds_left(i) > 0, moves = decides_motion(i);
  if ((!thins && !moves) || trainer.state().decided == i) return std::nullopt;
  const auto begin = std::chrono::steady_clock::now();
  const FrameSample sample = trainer.sample_frames();
  ReductionReport report;
  report.iteration = i;
  report.static_before = trainer.state().model.static_set.count();
  report.dynamic_before = trainer.state().model.dynamic_set.count();
  std::optional<Contributions> contributions;  // of the model as it is
  if (moves && has_timesteps(sample)) contributions = decide_motion(trainer, sample, report);
  if (thins) {
    if (!contributions)
      contributions = measure_contributions(backend_, trainer.drawn_model(), sample,
                                            knee_prices(trainer.drawn_model()));
    prune(trainer, sample, validation, std::move(*contributions), report);
  }
  report.static_after = trainer.state().model.static_set.count();
  report.dynamic_after = trainer.state().model.dynamic_set.count();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  trainer.note_decision(report.goal > 0 ? report.goal : trainer.state().goal, report.seconds);
  return report;
}

std::optional<Contributions> ModelReduction::decide_motion(Trainer& trainer,
                                                           const FrameSample& sample,
                                                           ReductionReport& report) {
  // of all; where several lie over each other, each spawned one would make up for the same error
  constexpr double kMostTimeVarying = 0.1, kMostSpawned = 0.02;
  // a few frames see a timestep, so motion fits what only these show: its error in training is
  // less than that of a Gaussian that all of them see. Of 1, 16 and 64 on five scenes
  // (docs/explanation/size.md)
  constexpr double kMotionCharge = 16;
  const ByteRates rates;
  const GaussianModel& model = trainer.drawn_model();
  Contributions contributions = measure_contributions(backend_, model, sample, knee_prices(model));
  report.sampled_frames = std::llround(contributions.share * double(sample.count()));
  const std::vector<Removal> order = removal_order(model, contributions);
  report.psnr = contributions.psnr_after(0);
  report.error_per_byte = error_per_byte_at(order, knee_count(order, contributions));
  const DemotionTrial trial = try_demotion(backend_, model, contributions, sample,
                                           kMotionCharge * report.error_per_byte * rates.time);
  // gains of the images, and where things are, are not known at the first decision; what is new
  // at the last round is not learnt any more
  const bool wakes = rounds_left(report.iteration) != 1 && trainer.state().decided > 0;
  const auto time_varying_share = [&](double share) {
    return time_varying_elements(
        contributions, report.error_per_byte * rates.bytes_of(true, model.drawing.sh_degree),
        wakes ? int64_t(share * double(model.count())) : 0);
  };
  const std::vector<int64_t> varying = time_varying_share(kMostTimeVarying);
  const GaussianSet moving = as_dynamic(backend_, model, contributions, varying);
  const GaussianSet spawned =
      spawn_dynamic(backend_, model, contributions, time_varying_share(kMostSpawned));
  report.demoted = int64_t(trial.elements.size());
  report.promoted = int64_t(varying.size());
  report.spawned = spawned.count();
  report.demotion_error = trial.error;
  if (trial.elements.empty() && varying.empty()) return contributions;
  trainer.edit([&](TrainState& state) {
    drop_elements(backend_, state, 0, varying);
    drop_elements(backend_, state, 1, trial.elements);
    add_elements(backend_, state, 0, trial.demoted);
    add_elements(backend_, state, 1, moving.clone_values(backend_.memory()));
    add_elements(backend_, state, 1, spawned.clone_values(backend_.memory()));
  });
  return std::nullopt;
}

void ModelReduction::prune(Trainer& trainer, const FrameSample& sample,
                           const ValidationRecord& validation, Contributions contributions,
                           ReductionReport& report) {
  std::vector<Removal> order = removal_order(trainer.state().model, contributions);
  report.sampled_frames = std::llround(contributions.share * double(sample.count()));
  report.psnr = contributions.psnr_after(0);
  report.knee = knee_count(order, contributions);
  report.error_per_byte = error_per_byte_at(order, report.knee);
  const int64_t before = trainer.state().model.count();
  if (before == 0) return;
  int64_t count = before, goal = trainer.state().goal;
  if (goal == 0 || options_.size != ModelSize::kKnee || options_.within_db > 0)
    goal = goal_of(trainer, order, contributions, validation, report.knee);
  report.goal = goal = std::clamp<int64_t>(goal, 1, count);
  const double share = options_.within_db > 0 ? 1.0 : 1.0 / double(rounds_left(report.iteration));
  count = std::llround(double(count) * std::pow(double(goal) / double(count), share));
  report.removed = before - count;
  // what hides behind those that go is seen only when they are gone: no more than a share at once
  constexpr double kAtOnce = 0.25;
  for (int64_t now = before; now > count;) {
    const int64_t next =
        std::max(count, now - std::max<int64_t>(1, int64_t(kAtOnce * double(now))));
    const KeptElements kept = kept_elements(trainer.state().model, order, next);
    trainer.edit([&](TrainState& state) { keep_elements(backend_, state, kept); });
    const GaussianModel& model = trainer.drawn_model();
    contributions = measure_contributions(backend_, model, sample, [&](const Contributions&) {
      return element_prices(model, report.error_per_byte);
    });
    order = removal_order(trainer.state().model, contributions);
    now = next;
  }
  report.psnr_after = contributions.psnr_after(0);
  if (options_.decide_colour && rounds_left(report.iteration) == 1)
    decide_colour(trainer, contributions, report.error_per_byte, report);
}

void ModelReduction::decide_colour(Trainer& trainer, const Contributions& contributions,
                                   double error_per_byte, ReductionReport& report) {
  const ByteRates rates;
  trainer.edit([&](TrainState& state) {
    for (int k = 0; k < 2; ++k) {
      std::vector<uint8_t> degrees = sh_degrees(state.set(k));
      for (size_t n = 0; n < degrees.size(); ++n) {
        const int most = std::min(int(degrees[n]), state.model.drawing.sh_degree);
        double least = error_per_byte * rates.bytes_of(k == 1, most);
        for (int d = most - 1; d >= 0; --d) {
          const double cost = double(contributions.sets[k].truncation_error[n][size_t(d)]) +
                              error_per_byte * rates.bytes_of(k == 1, d);
          if (cost <= least) {
            least = cost;
            degrees[n] = uint8_t(d);
          }
        }
        ++report.degrees[degrees[n]];
      }
      set_sh_degrees(backend_, degrees, state.set(k), state.statistics[k]);
    }
  });
}

nlohmann::json to_json(const ReductionReport& report) {
  return {{"iteration", report.iteration},
          {"looked_at", report.sampled_frames},
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
          {"price", report.error_per_byte},
          {"still_error", report.demotion_error},
          {"psnr", report.psnr},
          {"thinned", report.psnr_after},
          {"degrees", report.degrees},
          {"decision_seconds", report.seconds}};
}

}  // namespace tessera
