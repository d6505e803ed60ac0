// Compares each rate with the median one.
#include "ingest/clocks/frame_rates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr double kSameRate = 0.02;  // of a rate: 24 and 25 differ by twice that

/// The median of what is known; 0 of fewer than two.
double usual_seconds(const std::vector<double>& frame_seconds) {
  std::vector<double> known;
  for (const double seconds : frame_seconds)
    if (seconds > 0) known.push_back(seconds);
  return known.size() < 2 ? 0 : lower_median(std::move(known));
}

bool is_odd(double seconds, double usual) {
  return seconds > 0 && usual > 0 && std::abs(seconds - usual) > kSameRate * usual;
}

/// "24 frames/s", "29.97 frames/s".
std::string rate_text(double frame_seconds) {
  return fmt::format("{:g} frames/s", std::round(100 / frame_seconds) / 100);
}

}  // namespace

std::vector<char> odd_rates(const std::vector<double>& frame_seconds) {
  const double usual = usual_seconds(frame_seconds);
  std::vector<char> odd;
  for (const double seconds : frame_seconds) odd.push_back(is_odd(seconds, usual));
  return odd;
}

int64_t cameras_of_rate(double seconds, const std::vector<double>& frame_seconds) {
  if (seconds <= 0) return 0;
  return std::count_if(frame_seconds.begin(), frame_seconds.end(),
                       [&](double other) { return other > 0 && !is_odd(other, seconds); });
}

std::vector<std::string> rate_texts(const std::vector<double>& frame_seconds) {
  const std::vector<char> differs = odd_rates(frame_seconds);
  const double usual = usual_seconds(frame_seconds);
  std::vector<std::string> texts;
  for (size_t i = 0; i < frame_seconds.size(); ++i)
    texts.push_back(usual > 0 ? rate_text(differs[i] ? frame_seconds[i] : usual) : "");
  return texts;
}

std::string fps_warning(double fps, const std::vector<double>& frame_seconds) {
  double least = 0;
  for (const double seconds : frame_seconds)
    if (seconds > 0 && (least == 0 || seconds < least)) least = seconds;
  if (least == 0 || fps * least <= 1 + kSameRate) return "";
  return fmt::format("--fps {:g}: the videos have {}, all of which are kept; no frame is made up",
                     fps, rate_text(least));
}

}  // namespace tessera
