// The prices of motion, the verdict on a trial of demotion and the choice of promotions. The rules
// and the measurements behind their constants are in docs/explanation/static-dynamic.md and
// size.md.
#include "recon4d/reduction/motion_choice.h"

#include <algorithm>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/reduction/dynamic_promotion.h"

namespace tessera {

MotionPrices motion_prices(const std::vector<Removal>& order, const Contributions& contributions,
                           int sh_degree) {
  // A few frames see a timestep, so motion fits what only these show: its error in training is less
  // than that of a Gaussian that all of them see. Chosen of 1, 16 and 64 on five scenes
  // (docs/explanation/size.md).
  constexpr double kMotionCharge = 16;
  const ByteRates rates;
  MotionPrices prices;
  prices.error_per_byte = error_per_byte_at(order, knee_count(order, contributions));
  prices.allowed_demotion = kMotionCharge * prices.error_per_byte * rates.time;
  prices.least_promotion = prices.error_per_byte * rates.bytes_of(true, sh_degree);
  return prices;
}

DemotionVerdict judge(const DemotionRound& round) {
  // One of 50 accepted candidates: another round would change as few of the others' shares.
  constexpr int64_t kFewRejected = 50;
  check(round.added_error.size() == round.candidates.size(), "judge: one share a candidate");
  std::vector<std::pair<double, int64_t>> accepted;
  for (size_t i = 0; i < round.candidates.size(); ++i)
    if (round.added_error[i] <= round.allowed)
      accepted.emplace_back(round.added_error[i], round.candidates[i]);
  const bool together = round.total <= round.allowed * double(round.candidates.size());
  const int64_t rejected = int64_t(round.candidates.size() - accepted.size());
  if (rejected == 0 && together) return {round.candidates, round.total, true};
  if (rejected == 0) {
    std::stable_sort(accepted.begin(), accepted.end());
    accepted.resize(accepted.size() / 2);
  }
  if (round.is_last && !together) accepted.clear();
  DemotionVerdict verdict;
  for (const auto& [error, element] : accepted) {
    verdict.accepted.push_back(element);
    verdict.error += error;
  }
  std::sort(verdict.accepted.begin(), verdict.accepted.end());
  verdict.finished = round.is_last || accepted.empty() ||
                     (together && rejected * kFewRejected <= int64_t(accepted.size()));
  return verdict;
}

PromotionChoice choose_promotion(const Contributions& contributions, const MotionPrices& prices,
                                 int64_t gaussians, bool promote) {
  // Shares of all Gaussians. Where several lie over each other, each spawned one would make up for
  // the same error.
  constexpr double kMostPromoted = 0.1, kMostSpawned = 0.02;
  if (!promote) return {};
  const auto up_to = [&](double share) {
    return time_varying_elements(contributions, prices.least_promotion,
                                 int64_t(share * double(gaussians)));
  };
  return {up_to(kMostPromoted), up_to(kMostSpawned)};
}

}  // namespace tessera
