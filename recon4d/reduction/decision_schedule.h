// The steps at which a training decides on its Gaussians, as they follow from the options: rounds
// of pruning after growth, and decisions of motion while the sets grow and at each round.
// Source: docs/explanation/size.md.
#pragma once
#include <cstdint>
#include <vector>

#include "recon4d/options/train_options.h"

namespace tessera {

/// What is decided after a step.
struct DueDecision {
  int64_t iteration = 0;    // steps done
  int64_t rounds_left = 0;  // rounds of pruning that are left, with this one; 0: this is none
  bool motion = false;      // static or dynamic
  bool prune = false;
  /// Whether dynamic Gaussians are tried as static ones, which costs most of a decision's passes:
  /// at the first decision, when what stands still is known, and at the last, when all is learnt.
  /// Between them hardly any changes.
  bool demote = false;
  /// Whether static Gaussians may become dynamic, where motion is decided. The first decision does
  /// not promote, because the gains of the images and the places of the Gaussians are not known
  /// yet. The last round does not, because nothing is trained long enough after it.
  bool promote = false;
  bool spawn_missed = false;  // at the first decision

  bool any() const { return motion || prune; }
};

class DecisionSchedule {
 public:
  explicit DecisionSchedule(const TrainOptions& options);

  /// The next step after `iteration` at which something is decided; the largest number where there
  /// is none.
  int64_t next_after(int64_t iteration) const;
  /// What is due after `iteration` steps when the last decision was made after `decided` steps, 0
  /// for none. A step decides once.
  DueDecision due(int64_t iteration, int64_t decided) const;
  /// Whether the last round of pruning has been done by a decision after `iteration` steps; true
  /// where there are no rounds.
  bool has_pruned(int64_t iteration) const;

 private:
  int64_t rounds_left(int64_t iteration) const;

  bool decides_motion_;  // between static and dynamic, also at rounds
  bool spawn_missed_;
  std::vector<int64_t> rounds_, motion_;  // steps, ascending
};

}  // namespace tessera
