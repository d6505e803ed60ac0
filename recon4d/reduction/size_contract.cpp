// What: one look at all frames, then the number of Gaussians that fits.
// Not: the order in which they go (thinning.h).
#include "recon4d/reduction/size_contract.h"

#include <algorithm>

#include "recon4d/reduction/thinning.h"

namespace tessera {
namespace {

/// The largest number in [low, high] that is good, where those up to it are and those above are
/// not; to `step`. `low` is taken to be good.
int64_t largest_good(int64_t low, int64_t high, int64_t step,
                     const std::function<bool(int64_t count)>& good) {
  if (good(high)) return high;
  while (high - low > step) {
    const int64_t middle = low + (high - low) / 2;
    (good(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

GaussianModel fit_to(const SizeContract& contract, Backend& backend, const GaussianModel& model,
                     const LookedAt& at) {
  const Worth worth = measure_worth(backend, model, at);
  const std::vector<Removal> order = removal_order(model, worth);
  int64_t unseen = 0;
  for (const SetWorth& of : worth.sets)
    unseen += std::count_if(of.weight.begin(), of.weight.end(), [](float w) { return !(w > 0); });
  const auto left = [&](int64_t count) { return with_rows(model, kept_rows(model, order, count)); };
  int64_t count = model.count() - unseen;
  const int64_t step = std::max<int64_t>(1, count / 1000);
  if (contract.gaussians > 0) {
    count = std::min(count, contract.gaussians);
  } else if (contract.bytes > 0) {
    count = largest_good(0, count, step, [&](int64_t c) {
      return contract.shipped_bytes(left(c)) <= contract.bytes;
    });
  } else if (contract.least_psnr > 0) {
    count -= largest_good(0, count, step, [&](int64_t gone) {
      return contract.psnr(left(count - gone)) >= contract.least_psnr;
    });
  }
  return left(count);
}

}  // namespace tessera
