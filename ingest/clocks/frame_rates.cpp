// Compares each rate with the median one.
#include "ingest/clocks/frame_rates.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

/// "24", "29.97".
std::string rate_text(double frame_seconds) {
  return fmt::format("{:g}", std::round(100 / frame_seconds) / 100);
}

}  // namespace

std::string rate_warning(const std::vector<std::string>& cameras,
                         const std::vector<double>& frame_seconds) {
  constexpr double kAlike = 0.02;  // of the rate: 24 and 25 differ by twice that
  check(cameras.size() == frame_seconds.size(), "rate_warning: a rate for each camera");
  std::vector<double> known;
  for (const double seconds : frame_seconds)
    if (seconds > 0) known.push_back(seconds);
  if (known.size() < 2) return "";
  const double usual = lower_median(std::move(known));
  std::vector<std::string> odd, others;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const double seconds = frame_seconds[i];
    if (seconds > 0 && std::abs(seconds - usual) > kAlike * usual)
      odd.push_back(fmt::format("{} has {} frames/s", cameras[i], rate_text(seconds)));
    else
      others.push_back(cameras[i]);
  }
  if (odd.empty()) return "";
  return fmt::format(
      "{}, the other{} {}: each frame keeps its own time, but fewer timesteps are seen by all "
      "cameras; film at one rate{}",
      listed_names(odd), others.size() == 1 ? "" : "s", rate_text(usual),
      others.size() < 2 ? "" : fmt::format(", or pass --cameras {}", fmt::join(others, ",")));
}

}  // namespace tessera
