// Curves and points as an SVG image, which needs no other program and no script.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Least and most of what a point is the median of.
struct ChartSpan {
  double least = 0, most = 0;
};

struct ChartPoint {
  double x = 0, y = 0;
  std::optional<ChartSpan> x_span{}, y_span{};  // drawn as error bars
  std::string label{};                          // a few characters beside the point; or empty
};

enum class ChartLine { kNone, kSolid, kDashed };
enum class ChartMark {
  kNone,
  kDot,    // where a curve with a line has few points
  kRing,   // larger than a dot, so that one within it is seen
  kSquare  // open
};

struct ChartCurve {
  std::string name;                // in the legend
  std::string colour;              // of CSS, e.g. "#0072B2" or "currentColor"
  std::vector<ChartPoint> points;  // by x; one that has no place interrupts the curve
  ChartLine line = ChartLine::kSolid;
  ChartMark mark = ChartMark::kDot;
  double width = 2;  // of the line, in pixels of a chart of 480
};

struct Chart {
  std::string title;
  std::string x_axis, y_axis;  // with units, e.g. "PSNR [dB]"
  std::vector<ChartCurve> curves;
  bool from_zero = false;       // whether the y axis begins at 0; the linear x axis always does
  bool logarithmic_x = false;   // points at x ≤ 0 have no place then
  bool has_last_values = true;  // whether the legend has the last value of each curve
};

/// One `<svg>` element, which is also a whole file. Text and axes have the colour of the text
/// around it, so that it fits light and dark pages. The legend lies below the axes. Few points are
/// marked one by one and have a tooltip. A label that has no room without covering another is left
/// out. Names may be any text: they are escaped. A chart without a point that has a place (finite
/// numbers, x > 0 on a logarithmic axis) is "".
std::string svg_chart(const Chart& chart);

/// Several charts as one `<svg>` element: `columns` (≥ 1) side by side, row by row, under a title.
/// Charts that would be "" are left out; "" where none is left.
std::string svg_charts(const std::string& title, const std::vector<Chart>& charts, size_t columns);

/// The one colour of a preset in all charts and tables; a name that is no preset has the colour
/// that its letters select, never that of a preset.
std::string preset_colour(std::string_view preset);

}  // namespace tessera
