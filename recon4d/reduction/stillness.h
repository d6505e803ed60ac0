// What: which dynamic Gaussians may be static: tried, all at once, over all cameras and moments;
//       the error that it adds is shared out by light.
// Not: a threshold on how long a Gaussian lasts or how fast it is.
// Source: docs/parsimony.md; idea of a Gaussian that gives up its time: [Hybrid4D].
#pragma once
#include "recon4d/reduction/worth.h"

namespace tessera {

/// Gaussians of a dynamic set as static ones: where and as opaque as they are on the average of
/// their light, with the shape and colours of their slice there. Rows without light or that are
/// no Gaussians are where their own moment has them.
GaussianSet still_form(const GaussianModel& model, const SetWorth& worth);

struct StillTrial {
  std::vector<int64_t> rows;  // of the dynamic set that may be static, ascending
  GaussianSet still{Form::kStatic, kMaxShCoefficients};  // [rows] what they become
  /// Squared error that all of them add; where the last round has taken some away, the sum of the
  /// shares that the others had in it.
  double error = 0;
};
/// `allowed`: squared error that one of them may add; `rounds`: how often those that are left are
/// tried, at most. The model lies in the host's memory.
StillTrial try_still(Backend& backend, const GaussianModel& model, const Worth& worth,
                     const LookedAt& at, double allowed, int rounds = 4);

}  // namespace tessera
