// Axes, curves and legend, each as SVG elements with coordinates in units of the view box.
#include "tools/report/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/player/page_words.h"

namespace tessera {
namespace {

// units of the view box; shown at about one pixel each
constexpr double kWidth = 480, kPlotHeight = 210;
constexpr double kLeft = 68, kRight = 14, kTop = 34, kAxisHeight = 44, kLegendLine = 22;
constexpr size_t kMarkedPoints = 24;  // curves of more points are lines alone

bool is_finite(const ChartPoint& point) {
  return std::isfinite(point.x) && std::isfinite(point.y);
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

/// The value range of one axis and the place of values in the view box.
struct Axis {
  std::vector<double> ticks;
  double begin, end;  // where the first and the last tick lie

  double place(double value) const {
    const double share = (value - ticks.front()) / (ticks.back() - ticks.front());
    return begin + share * (end - begin);
  }
};

std::string text(double x, double y, const char* anchor, const std::string& words,
                 const std::string& more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, more, html_text(words));
}

std::string grid_line(double x1, double y1, double x2, double y2) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"currentColor\" "
      "stroke-opacity=\"0.15\"/>\n",
      x1, y1, x2, y2);
}

std::string axes(const Chart& chart, const Axis& x, const Axis& y) {
  std::string svg = text(kLeft, 20, "start", chart.title, " font-weight=\"600\" font-size=\"14\"");
  for (const double tick : y.ticks) {
    svg += grid_line(x.begin, y.place(tick), x.end, y.place(tick));
    svg += text(x.begin - 7, y.place(tick) + 4, "end", short_number(tick));
  }
  for (const double tick : x.ticks) {
    svg += grid_line(x.place(tick), y.begin, x.place(tick), y.end);
    svg += text(x.place(tick), y.begin + 17, "middle", short_number(tick));
  }
  svg += text((x.begin + x.end) / 2, y.begin + 36, "middle", chart.x_axis);
  const double middle = (y.begin + y.end) / 2;
  return svg + text(15, middle, "middle", chart.y_axis,
                    fmt::format(" transform=\"rotate(-90 15 {:.1f})\"", middle));
}

/// The curve as lines, and its points where they are few.
std::string curve_elements(const ChartCurve& curve, const Axis& x, const Axis& y) {
  std::string path, marks;
  const std::string colour = html_text(curve.colour);
  bool is_open = false;
  for (const ChartPoint& point : curve.points) {
    if (!is_finite(point)) {
      is_open = false;
      continue;
    }
    path += fmt::format("{}{:.1f} {:.1f}", is_open ? "L" : "M", x.place(point.x), y.place(point.y));
    is_open = true;
    if (curve.points.size() <= kMarkedPoints)
      marks += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\" fill=\"{}\"><title>{}: {} at {}</title>"
          "</circle>\n",
          x.place(point.x), y.place(point.y), colour, html_text(curve.name), short_number(point.y),
          short_number(point.x));
  }
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\" "
      "stroke-linejoin=\"round\"/>\n{}",
      path, colour, marks);
}

/// A line of the legend: the curve's colour, its name and its last value.
std::string legend_line(const ChartCurve& curve, double top) {
  std::string last;
  for (const ChartPoint& point : curve.points)
    if (is_finite(point)) last = ": " + short_number(point.y);
  return fmt::format(
             "<rect x=\"{}\" y=\"{:.1f}\" width=\"18\" height=\"4\" rx=\"2\" fill=\"{}\"/>\n",
             kLeft, top - 6, html_text(curve.colour)) +
         text(kLeft + 26, top, "start", curve.name + last);
}

}  // namespace

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
  const auto first = int64_t(std::floor(low / step + 1e-9));
  const auto last = int64_t(std::ceil(high / step - 1e-9));
  for (int64_t i = first; i <= last; ++i) ticks.push_back(double(i) * step);
  return ticks;
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

std::string svg_chart(const Chart& chart) {
  Range x_range, y_range;
  for (const ChartCurve& curve : chart.curves)
    for (const ChartPoint& point : curve.points) {
      if (!is_finite(point)) continue;
      x_range.add(point.x);
      y_range.add(point.y);
    }
  if (y_range.empty()) return "";
  x_range.add(0);
  if (chart.from_zero) y_range.add(0);
  const Axis x{axis_ticks(x_range.low, x_range.high, 6), kLeft, kWidth - kRight};
  const Axis y{axis_ticks(y_range.low, y_range.high, 5), kTop + kPlotHeight, kTop};
  std::string body = axes(chart, x, y);
  double legend_top = y.begin + kAxisHeight + kLegendLine * 0.75;
  for (const ChartCurve& curve : chart.curves) {
    if (std::none_of(curve.points.begin(), curve.points.end(), is_finite)) continue;
    body += curve_elements(curve, x, y);
    body += legend_line(curve, legend_top);
    legend_top += kLegendLine;
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {:.0f}\" role=\"img\" "
      "aria-label=\"{}\" font-family=\"system-ui, sans-serif\" font-size=\"13\" "
      "fill=\"currentColor\">\n{}</svg>\n",
      kWidth, legend_top - kLegendLine * 0.5, html_text(chart.title), body);
}

}  // namespace tessera
