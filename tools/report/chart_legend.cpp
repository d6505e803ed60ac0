// Entries two to a row; one that is too wide for that has a row alone.
#include "tools/report/chart_legend.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/report/chart_labels.h"
#include "tools/report/svg_elements.h"

namespace tessera {
namespace {

constexpr double kLegendFont = 13, kRow = 22, kSwatch = 18, kIndent = 26, kSpace = 16;

/// A piece of the line, or the mark of a curve without one.
std::string swatch(const ChartCurve& curve, double left, double middle) {
  if (curve.line == ChartLine::kNone) return svg_mark(curve, left + kSwatch / 2, middle, "");
  ChartCurve thick = curve;
  thick.width = std::max(curve.width, 3.0);
  return svg_line(thick, fmt::format("M{:.1f} {:.1f}H{:.1f}", left, middle, left + kSwatch));
}

}  // namespace

std::pair<std::string, double> legend_elements(const std::vector<LegendEntry>& entries, double left,
                                               double top, double width) {
  const double column = width / 2;
  std::string svg;
  size_t row = 0;
  bool is_second = false;  // whether the first column of the row is taken
  for (const LegendEntry& entry : entries) {
    const bool is_wide = kIndent + text_width(entry.words, kLegendFont) + kSpace > column;
    if (is_wide && std::exchange(is_second, false)) ++row;
    const double x = left + (is_second ? column : 0);
    const double baseline = top + kRow * (double(row) + 0.75);
    svg += swatch(*entry.curve, x, baseline - 4);
    svg += svg_text(x + kIndent, baseline, "start", entry.words, "",
                    TextRoom{kLegendFont, (is_wide ? width : column) - kIndent});
    if (is_wide || is_second) ++row;
    is_second = !is_wide && !is_second;
  }
  return {svg, kRow * (double(row + size_t(is_second)) + 0.25)};
}

}  // namespace tessera
