// The legend of a chart: each curve's line or mark with its name.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "tools/report/svg_chart.h"

namespace tessera {

struct LegendEntry {
  const ChartCurve* curve;
  std::string words;
};

/// SVG elements below `top`, and how high they are, in units of the view box. Entries stand in two
/// columns; one whose words do not fit in a column has a row alone.
std::pair<std::string, double> legend_elements(const std::vector<LegendEntry>& entries, double left,
                                               double top, double width);

}  // namespace tessera
