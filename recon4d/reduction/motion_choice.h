// Decisions between static and dynamic Gaussians as pure functions: measured errors and prices go
// in, choices come out. Nothing is drawn and no model is changed here.
// Source: docs/explanation/static-dynamic.md.
#pragma once
#include <cstdint>
#include <vector>

#include "recon4d/reduction/pruning.h"

namespace tessera {

/// Squared errors over all training images, range [0, 1], at the exchange rate of the knee.
struct MotionPrices {
  double error_per_byte = 0;    // squared error per byte of the exported file
  double allowed_demotion = 0;  // that one Gaussian may add by becoming static
  double least_promotion = 0;   // that a Gaussian must take away by becoming dynamic
};
/// `order`: as removal_order returns it for `contributions`; `sh_degree`: of the drawn model.
MotionPrices motion_prices(const std::vector<Removal>& order, const Contributions& contributions,
                           int sh_degree);

/// One trial of demotion: all candidates are drawn as static Gaussians at once.
struct DemotionRound {
  std::vector<int64_t> candidates;  // elements of the dynamic set, ascending
  std::vector<double> added_error;  // [candidates] squared error, each candidate's share
  double total = 0;                 // squared error that all of them add together
  double allowed = 0;               // MotionPrices::allowed_demotion
  bool is_last = false;             // no further round may follow
};
struct DemotionVerdict {
  std::vector<int64_t> accepted;  // candidates that are left, ascending
  /// Squared error that the accepted ones add: the total where all are accepted, else the sum of
  /// their shares.
  double error = 0;
  bool finished = false;  // no further round is needed
};
/// Accepts the candidates whose share is allowed. The total counts too, because some error is in no
/// candidate's share: where it exceeds what is allowed for all, though each share is allowed, only
/// the half with the smaller shares remains, and the last round accepts none. The trial is finished
/// when few were rejected, because another round would hardly change the shares of the others.
DemotionVerdict judge(const DemotionRound& round);

/// Elements of the static set, ascending.
struct PromotionChoice {
  std::vector<int64_t> promoted;  // become dynamic
  std::vector<int64_t> spawned;   // get a new dynamic Gaussian beside them
};
/// `gaussians`: of both sets, which the number of choices is proportional to; `promote`:
/// DueDecision::promote, without which nothing is chosen.
PromotionChoice choose_promotion(const Contributions& contributions, const MotionPrices& prices,
                                 int64_t gaussians, bool promote);

}  // namespace tessera
