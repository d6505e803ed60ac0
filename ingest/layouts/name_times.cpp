// Units are told by the size of the numbers, or by their distances.
#include "ingest/layouts/name_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

struct Unit {
  const char* name;
  int64_t a_second;
};
constexpr std::array<Unit, 4> kUnits{
    {{"s", 1}, {"ms", 1'000}, {"µs", 1'000'000}, {"ns", 1'000'000'000}}};
constexpr size_t kLeast = 3;  // numbers of a sequence that may be times

/// Distances of neighbours, of all sequences.
std::vector<int64_t> steps_of(const std::vector<ImageSequence>& sequences) {
  std::vector<int64_t> steps;
  for (const ImageSequence& sequence : sequences)
    for (size_t i = 1; i < sequence.images.size(); ++i)
      steps.push_back(sequence.images[i].number - sequence.images[i - 1].number);
  std::sort(steps.begin(), steps.end());
  return steps;
}

bool are_since_1970(const std::vector<ImageSequence>& sequences, int64_t a_second) {
  constexpr int64_t kFirst = 1'000'000'000, kLast = 4'000'000'000;  // seconds: 2001, 2096
  return std::all_of(sequences.begin(), sequences.end(), [&](const ImageSequence& sequence) {
    return sequence.images.front().number / a_second >= kFirst &&
           sequence.images.back().number / a_second < kLast;
  });
}

int64_t median_of(const std::vector<int64_t>& steps) {
  return steps.empty() ? 0 : steps[(steps.size() - 1) / 2];
}

/// "times in ns, 30 a second, 0.4 ms off at most".
std::string text_of(const std::vector<ImageSequence>& sequences, const Rational& seconds) {
  const std::vector<int64_t> steps = steps_of(sequences);
  const int64_t median = median_of(steps);
  int64_t worst = 0;
  for (const int64_t step : steps)
    if (2 * step < 3 * median) worst = std::max(worst, std::abs(step - median));
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& each) {
    return each.a_second == seconds.denominator;
  });
  return fmt::format("times in {}, {:.4g} a second, {:.2g} ms off at most", unit->name,
                     1 / seconds.at(median), 1e3 * seconds.at(worst));
}

}  // namespace

int64_t median_step(const std::vector<ImageSequence>& sequences) {
  return median_of(steps_of(sequences));
}

std::optional<Rational> seconds_of_names(const std::vector<ImageSequence>& sequences) {
  for (const ImageSequence& sequence : sequences)
    if (sequence.images.size() < kLeast) return std::nullopt;
  if (sequences.empty()) return std::nullopt;
  for (const Unit& unit : kUnits)
    if (are_since_1970(sequences, unit.a_second)) return Rational{1, unit.a_second};
  constexpr double kLeastRate = 1, kMostRate = 500;
  const std::vector<int64_t> steps = steps_of(sequences);
  const int64_t median = median_of(steps);
  for (const Unit& unit : kUnits) {
    const double rate = double(unit.a_second) / double(std::max<int64_t>(1, median));
    const bool may_count_frames = unit.a_second <= 1'000;
    if (unit.a_second == 1 || rate < kLeastRate || rate > kMostRate) continue;
    if (may_count_frames && (median < 8 || steps.front() == steps.back())) continue;
    return Rational{1, unit.a_second};
  }
  return std::nullopt;
}

void take_times(ImageSequences& found) {
  std::vector<ImageSequence>& sequences = found.cameras;
  found.number_seconds = seconds_of_names(sequences);
  if (!found.number_seconds) return;
  found.times = text_of(sequences, *found.number_seconds);
  int64_t first = sequences.front().images.front().number;
  for (const ImageSequence& sequence : sequences)
    first = std::min(first, sequence.images.front().number);
  for (ImageSequence& sequence : sequences)
    for (NumberedImage& image : sequence.images) image.number -= first;
}

}  // namespace tessera
