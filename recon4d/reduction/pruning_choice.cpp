// Goals of pruning for each kind of size request, the way there, and the SH bands that remain.
#include "recon4d/reduction/pruning_choice.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// What is left over the goal for the exact cut in the end: some Gaussians die during recovery.
constexpr double kSpare = 1.04;

/// Gaussians that are left when removals take no more than `room` dB from the images. The training
/// recovers most of what this predicts.
int64_t count_within(const std::vector<Removal>& order, const Contributions& contributions,
                     double room) {
  double error = 0;
  int64_t gone = 0;
  for (; gone + 1 < int64_t(order.size()); ++gone) {
    error += order[size_t(gone)].error;
    if (contributions.psnr_after(0) - contributions.psnr_after(error) > room) break;
  }
  return int64_t(order.size()) - gone;
}

/// Gaussians whose file has about so many bytes, when that of all has `file_bytes`.
int64_t count_of_bytes(const std::vector<Removal>& order, double bytes, double file_bytes) {
  double all = 0;
  for (const Removal& removal : order) all += removal.bytes;
  const double scale = file_bytes / std::max(1.0, all);  // from the rates to the file
  double left = all * scale;
  int64_t gone = 0;
  while (gone < int64_t(order.size()) && left > bytes) left -= scale * order[size_t(gone++)].bytes;
  return int64_t(order.size()) - gone;
}

int64_t goal_of(const std::vector<Removal>& order, const Contributions& contributions,
                const SizeRequest& request, int64_t knee) {
  if (request.known_goal > 0) return request.known_goal;
  if (request.gaussians > 0) return int64_t(kSpare * double(request.gaussians));
  if (request.within_db > 0) return count_within(order, contributions, request.validation_room);
  if (request.bytes > 0)
    return count_of_bytes(order, kSpare * double(request.bytes), double(request.file_bytes));
  return knee;
}

}  // namespace

PruningChoice choose_pruning(const std::vector<Removal>& order, const Contributions& contributions,
                             const SizeRequest& request) {
  const int64_t now = seen_count(order);
  PruningChoice choice;
  choice.knee = knee_count(order, contributions);
  choice.error_per_byte = error_per_byte_at(order, choice.knee);
  if (now == 0) return choice;
  const int64_t goal = goal_of(order, contributions, request, choice.knee);
  choice.goal = std::clamp<int64_t>(goal, 1, now);
  const double share = request.within_db > 0 ? 1.0 : 1.0 / double(request.rounds_left);
  choice.after = std::llround(double(now) * std::pow(double(choice.goal) / double(now), share));
  return choice;
}

int64_t next_cut(int64_t now, int64_t after) {
  constexpr double kAtOnce = 0.25;
  return std::max(after, now - std::max<int64_t>(1, int64_t(kAtOnce * double(now))));
}

std::vector<uint8_t> choose_degrees(std::vector<uint8_t> degrees,
                                    const SetContributions& contributions, bool dynamic,
                                    int sh_degree, double error_per_byte) {
  const ByteRates rates;
  for (size_t n = 0; n < degrees.size(); ++n) {
    const int most = std::min(int(degrees[n]), sh_degree);
    double least = error_per_byte * rates.bytes_of(dynamic, most);
    for (int d = most - 1; d >= 0; --d) {
      const double cost = double(contributions.truncation_error[n][size_t(d)]) +
                          error_per_byte * rates.bytes_of(dynamic, d);
      if (cost <= least) {
        least = cost;
        degrees[n] = uint8_t(d);
      }
    }
  }
  return degrees;
}

}  // namespace tessera
