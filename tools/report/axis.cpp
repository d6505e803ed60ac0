// Round numbers for ticks, and places of values on linear and logarithmic axes.
#include "tools/report/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tessera {
namespace {

constexpr double kSameTick = 1e-9;  // relative: a bound this close to a tick is the tick

}  // namespace

void ValueRange::add(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

bool ChartAxis::has_place(double value) const {
  return std::isfinite(value) && (!logarithmic || value > 0);
}

double ChartAxis::place(double value) const {
  const auto scaled = [this](double number) { return logarithmic ? std::log10(number) : number; };
  const double first = scaled(ticks.front()), last = scaled(ticks.back());
  return begin + (scaled(value) - first) / (last - first) * (end - begin);
}

std::vector<double> axis_ticks(double low, double high, int intervals) {
  if (low == high) {
    const double room = low == 0 ? 1 : std::abs(low) * 0.05;
    low -= room;
    high += room;
  }
  const double rough = (high - low) / intervals;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double digit : {5.0, 2.0, 1.0})
    if (digit * power >= rough * 0.999) step = digit * power;
  std::vector<double> ticks;
  const auto first = int64_t(std::floor(low / step + kSameTick));
  const auto last = int64_t(std::ceil(high / step - kSameTick));
  for (int64_t i = first; i <= last; ++i) ticks.push_back(double(i) * step);
  return ticks;
}

std::vector<double> logarithmic_ticks(double low, double high) {
  constexpr double kManyDecades = 3;
  const bool powers_alone = std::log10(high / low) > kManyDecades;
  const std::vector<double> digits =
      powers_alone ? std::vector<double>{1} : std::vector<double>{1, 2, 5};
  const int first = int(std::floor(std::log10(low))) - 1;
  const int last = int(std::ceil(std::log10(high))) + 1;
  std::vector<double> all;
  for (int decade = first; decade <= last; ++decade)
    for (const double digit : digits)
      all.push_back(decade < 0 ? digit / std::pow(10, -decade) : digit * std::pow(10, decade));
  size_t begin = 0, end = all.size() - 1;
  while (all[begin + 1] <= low * (1 + kSameTick)) ++begin;
  while (all[end - 1] >= high * (1 - kSameTick)) --end;
  if (begin == end) {  // one value, which is a tick
    --begin;
    ++end;
  }
  return {all.begin() + ptrdiff_t(begin), all.begin() + ptrdiff_t(end) + 1};
}

std::string short_number(double value) {
  const double size = std::abs(value);
  if (size >= 1e10) return fmt::format("{:.3g}G", value / 1e9);
  if (size >= 1e6) return fmt::format("{:.3g}M", value / 1e6);
  if (size >= 1e4) return fmt::format("{:.3g}k", value / 1e3);
  if (size >= 1e3) {
    const auto whole = std::llround(size);
    return fmt::format("{}{},{:03}", value < 0 ? "-" : "", whole / 1000, whole % 1000);
  }
  return fmt::format("{:.4g}", value);
}

}  // namespace tessera
