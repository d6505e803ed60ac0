// Compares distances as integers, so that rounding cannot move one across the threshold of 1.5
// medians.
#include "ingest/video/frame_timing.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr size_t kMostLines = 3;
constexpr size_t kVariableShare = 10;  // one gap in so many distances: the rate is variable

std::vector<int64_t> distances_of(const std::vector<int64_t>& ticks) {
  std::vector<int64_t> distances;
  for (size_t i = 1; i < ticks.size(); ++i) distances.push_back(ticks[i] - ticks[i - 1]);
  return distances;
}

std::string variable_rate(const std::string& camera, const std::vector<int64_t>& distances,
                          size_t gaps, const Rational& time_base) {
  const auto [shortest, longest] = std::minmax_element(distances.begin(), distances.end());
  return fmt::format(
      "{} has a variable frame rate, {} of {} distances are over 1.5 medians ({:.4f} to {:.4f} "
      "s); "
      "its frames keep their own times",
      camera, gaps, distances.size(), time_base.at(*shortest), time_base.at(*longest));
}

}  // namespace

int64_t median_distance(const std::vector<int64_t>& ticks) {
  std::vector<int64_t> distances = distances_of(ticks);
  if (distances.empty()) return 0;
  return lower_median(std::move(distances));
}

std::vector<std::string> gap_warnings(const std::string& camera, const std::vector<int64_t>& ticks,
                                      const Rational& time_base) {
  const int64_t median = median_distance(ticks);
  const std::vector<int64_t> distances = distances_of(ticks);
  std::vector<size_t> gaps;
  for (size_t i = 0; i < distances.size(); ++i)
    if (2 * distances[i] > 3 * median) gaps.push_back(i);
  if (gaps.size() > kMostLines && gaps.size() * kVariableShare > distances.size())
    return {variable_rate(camera, distances, gaps.size(), time_base)};
  std::vector<std::string> lines;
  for (size_t k = 0; k < std::min(gaps.size(), kMostLines); ++k) {
    const double missing = double(distances[gaps[k]]) / double(median) - 1;
    lines.push_back(fmt::format(
        "{} has a gap after {:.3f} s, {:.3f} s long: about {:.0f} frames "
        "are missing",
        camera, time_base.at(ticks[gaps[k]]), time_base.at(distances[gaps[k]]), missing));
  }
  if (gaps.size() > kMostLines)
    lines.push_back(fmt::format("{} has {} gaps in all, the last after {:.3f} s", camera,
                                gaps.size(), time_base.at(ticks[gaps.back()])));
  return lines;
}

std::vector<std::string> duplicate_warnings(const std::string& camera,
                                            const std::vector<int64_t>& repeated,
                                            const Rational& time_base) {
  if (repeated.empty()) return {};
  return {fmt::format(
      "{} has {} frames that repeat the presentation time of another, first at {:.3f} s; "
      "the first frame of each time is used",
      camera, repeated.size(), time_base.at(repeated.front()))};
}

}  // namespace tessera
