// Curves as an SVG image, written directly: no other program and no script is needed to see it.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

struct ChartPoint {
  double x = 0, y = 0;
};

struct ChartCurve {
  std::string name;                // in the legend
  std::string colour;              // of CSS, e.g. "#0072B2"
  std::vector<ChartPoint> points;  // by x; a point that is not finite interrupts the curve
};

struct Chart {
  std::string title;
  std::string x_axis, y_axis;  // with units, e.g. "PSNR [dB]"
  std::vector<ChartCurve> curves;
  bool from_zero = false;  // whether the y axis begins at 0
};

/// One `<svg>` element, which is also a whole file. Text and axes have the colour of the text
/// around it, so that it fits light and dark pages. The legend lies below the axes; each curve has
/// its last value there. Few points are marked one by one and have a tooltip. Names may be any
/// text: they are escaped. A chart without a finite point is "".
std::string svg_chart(const Chart& chart);

/// Round numbers that divide [low, high] into about `intervals` parts of 1, 2 or 5 times a power
/// of ten, ascending; the first is ≤ low and the last ≥ high. Both must be finite and low ≤ high;
/// an empty range is widened.
std::vector<double> axis_ticks(double low, double high, int intervals);

/// A number of an axis or legend in few characters: "0.05", "28.31", "7,000", "52k", "1.2M".
std::string short_number(double value);

/// The one colour of a preset in all charts and tables; a name that is no preset has the colour
/// that its letters select, never that of a preset.
std::string preset_colour(std::string_view preset);

}  // namespace tessera
