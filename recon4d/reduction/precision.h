// What: how many frames a scoring pass draws: sweep after sweep until what one half of them decides
//       costs little by the other half.
// Not: the decisions (pruning.h, static_demotion.h), nor the order of frames (frame_sample.h).
// Source: docs/explanation/size.md.
#pragma once
#include <functional>
#include <vector>

#include "recon4d/evaluation/frame_sample.h"

namespace tessera {

/// An element is given up where the squared error that this adds is no more than its price. What
/// that costs when `first`, the errors by one half of the frames, decide and `second`, those by the
/// other half, judge, beyond the least possible; mean of that and of the other way round. Squared
/// error. `price`: by one half. 0: the halves decide alike. All [N].
double regret(const std::vector<double>& first, const std::vector<double>& second,
              const std::vector<double>& price);

/// A pass is precise enough where the regret of its halves is no more than this share of the price
/// of all elements, or than that of the images' squared error, which is 0.05 dB. Of the whole it is
/// half of that of the halves, or less: it has half of their variance.
inline constexpr double kRegretOfPrice = 0.02, kRegretOfError = 0.0116;

/// Errors [N] of a pass so far, and the prices and the images' squared error in the same frames.
struct PricedErrors {
  std::vector<double> error, price;
  double squared_error = 0;
};

/// Draws sweeps of `sample` and asks for `so_far` after 1, 2, 4, … of them, until the halves decide
/// alike; without `so_far` all. `draw`: frames [begin, end) of `sample`, of one series, at most
/// four of them. Returns the share of the frames that were drawn.
double draw_until_precise(
    const FrameSample& sample,
    const std::function<void(int64_t begin, int64_t end, int32_t series)>& draw,
    const std::function<PricedErrors(double share)>& so_far);

}  // namespace tessera
