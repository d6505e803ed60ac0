// One axis of a chart: the range of its values, its ticks, and the place of a value along it.
#pragma once
#include <limits>
#include <string>
#include <vector>

namespace tessera {

/// The least and the largest of the values added so far.
struct ValueRange {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  void add(double value);
  bool empty() const { return low > high; }
};

/// The first and the last tick are the ends of the axis.
struct ChartAxis {
  std::vector<double> ticks;  // ascending, two or more
  double begin = 0, end = 0;  // where the first and the last tick lie, in units of the view box
  bool logarithmic = false;   // all ticks are above 0 then

  /// Whether the value has a place: it is finite, and above 0 where the axis is logarithmic.
  bool has_place(double value) const;
  /// In units of the view box; the value has a place.
  double place(double value) const;
};

/// Round numbers that divide [low, high] into about `intervals` parts of 1, 2 or 5 times a power
/// of ten, ascending; the first is ≤ low and the last ≥ high. Both must be finite and low ≤ high;
/// an empty range is widened.
std::vector<double> axis_ticks(double low, double high, int intervals);

/// Ticks of a logarithmic axis: 1, 2 and 5 times the powers of ten, of more than three decades the
/// powers of ten alone; ascending, two or more, the first ≤ low and the last ≥ high. Both must be
/// finite and 0 < low ≤ high.
std::vector<double> logarithmic_ticks(double low, double high);

/// A number of an axis or legend in few characters: "0.05", "28.31", "7,000", "52k", "1.2M".
std::string short_number(double value);

}  // namespace tessera
