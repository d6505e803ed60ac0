// What: two halves of a pass, each judged by the other.
// Not: any image.
#include "recon4d/reduction/precision.h"

#include <algorithm>
#include <numeric>

namespace tessera {

double regret(const std::vector<double>& first, const std::vector<double>& second,
              const std::vector<double>& price) {
  double lost = 0;
  for (size_t n = 0; n < price.size(); ++n) {
    const double a = first[n], b = second[n], p = price[n];
    lost += (a <= p ? b : p) - std::min(b, p) + (b <= p ? a : p) - std::min(a, p);
  }
  return lost / 2;
}

double draw_until_precise(
    const FrameSample& sample,
    const std::function<void(int64_t begin, int64_t end, int32_t series)>& draw,
    const std::function<PricedErrors(double share)>& so_far) {
  constexpr int64_t kBatch = 4;  // frames drawn at once
  const auto sweeps = int64_t(sample.sweeps.size());
  int64_t drawn_frames = 0;
  int32_t series_number = 0;
  std::vector<double> first;  // errors by the first half
  for (int64_t sweep = 0; sweep < sweeps; ++sweep) {
    for (const FrameRange& series : sample.sweeps[size_t(sweep)]) {
      for (int64_t begin = series.begin; begin < series.end; begin += kBatch)
        draw(begin, std::min(begin + kBatch, series.end), series_number);
      drawn_frames += series.end - series.begin;
      ++series_number;
    }
    const int64_t drawn = sweep + 1;
    if (!so_far || drawn == sweeps || (drawn & (drawn - 1)) != 0) continue;
    PricedErrors now = so_far(double(drawn_frames) / double(sample.count()));
    if (drawn > 1) {
      std::vector<double> second = now.error;
      for (size_t n = 0; n < second.size(); ++n) second[n] -= first[n];
      for (double& price : now.price) price /= 2;
      const double prices = std::accumulate(now.price.begin(), now.price.end(), 0.0);
      if (regret(first, second, now.price) <=
          std::max(kRegretOfPrice * prices, kRegretOfError * now.squared_error / 2))
        return double(drawn_frames) / double(sample.count());
    }
    first = std::move(now.error);
  }
  return 1;
}

}  // namespace tessera
