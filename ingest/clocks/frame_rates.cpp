// Compares each rate with the median one.
#include "ingest/clocks/frame_rates.h"

#include <fmt/format.h>

#include <cmath>

#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

/// The median of what is known; 0 of fewer than two.
double usual_seconds(const std::vector<double>& frame_seconds) {
  std::vector<double> known;
  for (const double seconds : frame_seconds)
    if (seconds > 0) known.push_back(seconds);
  return known.size() < 2 ? 0 : lower_median(std::move(known));
}

/// "24", "29.97".
std::string rate_text(double frame_seconds) {
  return fmt::format("{:g}", std::round(100 / frame_seconds) / 100);
}

}  // namespace

std::vector<char> odd_rates(const std::vector<double>& frame_seconds) {
  constexpr double kAlike = 0.02;  // of the rate: 24 and 25 differ by twice that
  const double usual = usual_seconds(frame_seconds);
  std::vector<char> odd;
  for (const double seconds : frame_seconds)
    odd.push_back(seconds > 0 && usual > 0 && std::abs(seconds - usual) > kAlike * usual);
  return odd;
}

std::string rate_warning(const std::vector<std::string>& cameras,
                         const std::vector<double>& frame_seconds) {
  check(cameras.size() == frame_seconds.size(), "rate_warning: a rate for each camera");
  const std::vector<char> differs = odd_rates(frame_seconds);
  std::vector<std::string> odd;
  for (size_t i = 0; i < cameras.size(); ++i)
    if (differs[i])
      odd.push_back(fmt::format("{} has {} frames/s", cameras[i], rate_text(frame_seconds[i])));
  if (odd.empty()) return "";
  return fmt::format(
      "{}, the other{} {}: each frame keeps its own time, but fewer timesteps are seen by all "
      "cameras; film at one rate",
      listed_names(odd), cameras.size() - odd.size() == 1 ? "" : "s",
      rate_text(usual_seconds(frame_seconds)));
}

}  // namespace tessera
