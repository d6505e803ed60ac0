// Rounds of pruning are spread evenly from the end of growth to `thin_until`; all steps scale with
// the schedule.
#include "recon4d/reduction/decision_schedule.h"

#include <algorithm>
#include <limits>

#include "recon4d/training/schedule.h"

namespace tessera {
namespace {

bool contains(const std::vector<int64_t>& sorted, int64_t value) {
  return std::binary_search(sorted.begin(), sorted.end(), value);
}

/// Gaussians that motion nodes carry stay as they are.
bool decides_motion(const TrainOptions& options) {
  return options.decide_motion && options.motion != Motion::kNone &&
         options.motion != Motion::kNodes;
}

}  // namespace

DecisionSchedule::DecisionSchedule(const TrainOptions& options)
    : decides_motion_(decides_motion(options)), spawn_missed_(options.spawn_missed) {
  const int64_t grown = scaled_steps(options, options.densify_until) + 1;
  const int64_t last = std::max(grown, scaled_steps(options, options.thin_until));
  if (prunes_after_growth(options))
    for (int64_t r = 0; r < options.thin_rounds; ++r)
      rounds_.push_back(grown + (last - grown) * r / std::max<int64_t>(1, options.thin_rounds - 1));
  rounds_.erase(std::unique(rounds_.begin(), rounds_.end()), rounds_.end());
  std::erase_if(rounds_, [&](int64_t i) { return i >= options.iterations; });
  const int64_t interval = std::max<int64_t>(1, scaled_steps(options, options.decide_interval));
  if (decides_motion_)
    for (int64_t i = interval; i < std::min(grown, options.iterations); i += interval)
      motion_.push_back(i);
}

int64_t DecisionSchedule::next_after(int64_t iteration) const {
  int64_t next = std::numeric_limits<int64_t>::max();
  for (const std::vector<int64_t>* steps : {&rounds_, &motion_}) {
    const auto later = std::upper_bound(steps->begin(), steps->end(), iteration);
    if (later != steps->end()) next = std::min(next, *later);
  }
  return next;
}

DueDecision DecisionSchedule::due(int64_t iteration, int64_t decided) const {
  DueDecision due;
  due.iteration = iteration;
  if (iteration == decided) return due;
  due.rounds_left = rounds_left(iteration);
  due.prune = due.rounds_left > 0;
  due.motion = contains(motion_, iteration) || (decides_motion_ && due.prune);
  if (!due.motion) return due;
  due.spawn_missed = spawn_missed_ && decided == 0;
  const bool last = rounds_.empty() ? iteration == motion_.back() : due.rounds_left == 1;
  due.demote = decided == 0 || last;
  due.promote = due.rounds_left != 1 && decided > 0;
  return due;
}

bool DecisionSchedule::has_pruned(int64_t iteration) const {
  return rounds_.empty() || iteration >= rounds_.back();
}

int64_t DecisionSchedule::rounds_left(int64_t iteration) const {
  const auto now = std::lower_bound(rounds_.begin(), rounds_.end(), iteration);
  return now != rounds_.end() && *now == iteration ? rounds_.end() - now : 0;
}

}  // namespace tessera
