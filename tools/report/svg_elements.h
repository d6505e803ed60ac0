// Elements of a chart as SVG text: words, lines of curves, marks of points, the legend, and the
// colours of presets.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/report/svg_chart.h"

namespace tessera {

/// A text that would be wider than `width` at `font_size` is squeezed.
struct TextRoom {
  double font_size = 0, width = 0;
};

/// `words` are escaped; `more`: further attributes, each with a space before it.
std::string svg_text(double x, double y, const char* anchor, const std::string& words,
                     const std::string& more = "", std::optional<TextRoom> room = {},
                     const std::string& colour = "");

/// `path`: of the attribute d. The curve's line is not kNone.
std::string svg_line(const ChartCurve& curve, const std::string& path);

/// The curve's mark at (x, y); without a tooltip where it is empty. "" of kNone.
std::string svg_mark(const ChartCurve& curve, double x, double y, const std::string& tooltip);

struct LegendEntry {
  const ChartCurve* curve;
  std::string words;
};

/// SVG elements below `top`, and how high they are, in units of the view box. Entries stand in two
/// columns; one whose words do not fit in a column has a row alone.
std::pair<std::string, double> legend_elements(const std::vector<LegendEntry>& entries, double left,
                                               double top, double width);

}  // namespace tessera
