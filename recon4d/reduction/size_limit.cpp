// One scoring pass over all frames, then a search for the number of Gaussians that fits the limit.
#include "recon4d/reduction/size_limit.h"

#include <algorithm>

#include "recon4d/reduction/pruning.h"

namespace tessera {
namespace {

/// The largest number in [low, high] that is good, where those up to it are and those above are
/// not; to `step`, and to one where that is less than `step` above `low`, which is taken to be
/// good.
int64_t largest_good(int64_t low, int64_t high, int64_t step,
                     const std::function<bool(int64_t count)>& good) {
  if (good(high)) return high;
  const int64_t first = low;
  while (high - low > (low == first ? 1 : step)) {
    const int64_t middle = low + (high - low) / 2;
    (good(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

GaussianModel without_still_dynamic(Backend& backend, const GaussianModel& model,
                                    const FrameSample& sample) {
  const std::vector<int64_t> still =
      still_dynamic(measure_contributions(backend, model, sample, kSampledFrames));
  KeptElements kept;
  for (int64_t n = 0; n < model.static_set.count(); ++n) kept.set_elements[0].push_back(n);
  for (int64_t n = 0; n < model.dynamic_set.count(); ++n)
    if (!std::binary_search(still.begin(), still.end(), n)) kept.set_elements[1].push_back(n);
  return with_elements(model, kept);
}

GaussianModel fit_to_limit(const SizeLimit& limit, Backend& backend, const GaussianModel& model,
                           const FrameSample& sample) {
  const int first = limit.static_is_frozen ? 1 : 0;
  const Contributions contributions = measure_contributions(backend, model, sample);
  const std::vector<Removal> order = removal_order(model, contributions, limit.static_is_frozen);
  int64_t unseen = 0;
  for (int k = first; k < 2; ++k) {
    const std::vector<float>& weight = contributions.sets[k].weight;
    unseen += std::count_if(weight.begin(), weight.end(), [](float w) { return !(w > 0); });
  }
  const auto left = [&](int64_t count) {
    return with_elements(model, kept_elements(model, order, count));
  };
  int64_t count = model.count() - unseen;
  const int64_t step = std::max<int64_t>(1, count / 1000);
  if (limit.gaussians > 0) {
    count = std::min(count, limit.gaussians);
  } else if (limit.bytes > 0) {
    count = largest_good(0, count, step,
                         [&](int64_t c) { return limit.shipped_bytes(left(c)) <= limit.bytes; });
  } else if (limit.least_psnr > 0) {
    count -= largest_good(0, count, step, [&](int64_t gone) {
      return limit.psnr(left(count - gone)) >= limit.least_psnr;
    });
  }
  return left(count);
}

}  // namespace tessera
