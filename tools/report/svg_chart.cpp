// Axes, curves, marks and labels, each as SVG elements with coordinates in units of the view box.
#include "tools/report/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/report/axis.h"
#include "tools/report/chart_labels.h"
#include "tools/report/svg_elements.h"
#include "tools/web/page_words.h"

namespace tessera {
namespace {

// units of the view box; shown at about one pixel each
constexpr double kWidth = 480, kPlotHeight = 210, kPanelGap = 40;
constexpr double kLeft = 68, kRight = 22, kTop = 34, kAxisHeight = 44, kHeading = 30;
constexpr size_t kMarkedPoints = 24;  // curves of more points are lines alone
constexpr double kFont = 13, kLabelFont = 11;

struct Axes {
  ChartAxis x, y;

  bool have_place(const ChartPoint& point) const {
    return x.has_place(point.x) && y.has_place(point.y);
  }
};

bool is_drawn(const ChartCurve& curve, const Axes& axes) {
  return std::any_of(curve.points.begin(), curve.points.end(),
                     [&](const ChartPoint& point) { return axes.have_place(point); });
}

/// Axes that hold all points and their error bars; nothing without a point.
std::optional<Axes> axes_of(const Chart& chart) {
  Axes axes{{{}, kLeft, kWidth - kRight, chart.logarithmic_x}, {{}, kTop + kPlotHeight, kTop}};
  ValueRange x_range, y_range;
  const auto add = [](ValueRange& range, const ChartAxis& axis, double value,
                      const std::optional<ChartSpan>& span) {
    range.add(value);
    if (!span) return;
    for (const double bound : {span->least, span->most})
      if (axis.has_place(bound)) range.add(bound);
  };
  for (const ChartCurve& curve : chart.curves)
    for (const ChartPoint& point : curve.points) {
      if (!axes.have_place(point)) continue;
      add(x_range, axes.x, point.x, point.x_span);
      add(y_range, axes.y, point.y, point.y_span);
    }
  if (y_range.empty()) return std::nullopt;
  if (!chart.logarithmic_x) x_range.add(0);
  if (chart.from_zero) y_range.add(0);
  axes.x.ticks = chart.logarithmic_x ? logarithmic_ticks(x_range.low, x_range.high)
                                     : axis_ticks(x_range.low, x_range.high, 6);
  axes.y.ticks = axis_ticks(y_range.low, y_range.high, 5);
  return axes;
}

std::string grid_line(double x1, double y1, double x2, double y2) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"currentColor\" "
      "stroke-opacity=\"0.15\"/>\n",
      x1, y1, x2, y2);
}

/// Numbers below the x axis, powers of ten first; one that would touch another is left out.
std::string x_numbers(const ChartAxis& x, double top) {
  std::vector<double> ticks = x.ticks;
  std::stable_partition(ticks.begin(), ticks.end(), [](double tick) {
    const double power = tick > 0 ? std::log10(tick) : 0;
    return std::abs(power - std::round(power)) < 1e-9;
  });
  std::string svg;
  std::vector<ChartBox> taken;
  for (const double tick : ticks) {
    const std::string words = short_number(tick);
    const double room = text_width(words, kFont) / 2 + 3, middle = x.place(tick);
    const ChartBox box{middle - room, 0, middle + room, 1};
    if (std::any_of(taken.begin(), taken.end(),
                    [&](const auto& other) { return box.overlaps(other); }))
      continue;
    taken.push_back(box);
    svg += svg_text(middle, top, "middle", words);
  }
  return svg;
}

std::string frame(const Chart& chart, const Axes& axes) {
  const auto& [x, y] = axes;
  std::string svg = svg_text(kLeft, 20, "start", chart.title,
                             " font-weight=\"600\" font-size=\"14\"", TextRoom{14, kWidth - kLeft});
  for (const double tick : y.ticks) {
    svg += grid_line(x.begin, y.place(tick), x.end, y.place(tick));
    svg += svg_text(x.begin - 7, y.place(tick) + 4, "end", short_number(tick));
  }
  for (const double tick : x.ticks) svg += grid_line(x.place(tick), y.begin, x.place(tick), y.end);
  svg += x_numbers(x, y.begin + 17);
  svg += svg_text((x.begin + x.end) / 2, y.begin + 36, "middle", chart.x_axis);
  const double middle = (y.begin + y.end) / 2;
  return svg + svg_text(15, middle, "middle", chart.y_axis,
                        fmt::format(" transform=\"rotate(-90 15 {:.1f})\"", middle));
}

/// Lines with small bars at their ends, where least and most differ.
std::string error_bars(const ChartCurve& curve, const ChartPoint& point, const Axes& axes) {
  const auto spans = [](const ChartAxis& axis, const std::optional<ChartSpan>& span) {
    return span && span->least < span->most && axis.has_place(span->least) &&
           axis.has_place(span->most);
  };
  const auto& [x, y] = axes;
  std::string path;
  if (spans(x, point.x_span))
    path += fmt::format("M{0:.1f} {2:.1f}H{1:.1f}M{0:.1f} {3:.1f}v6M{1:.1f} {3:.1f}v6",
                        x.place(point.x_span->least), x.place(point.x_span->most), y.place(point.y),
                        y.place(point.y) - 3);
  if (spans(y, point.y_span))
    path += fmt::format("M{2:.1f} {0:.1f}V{1:.1f}M{3:.1f} {0:.1f}h6M{3:.1f} {1:.1f}h6",
                        y.place(point.y_span->least), y.place(point.y_span->most), x.place(point.x),
                        x.place(point.x) - 3);
  if (path.empty()) return "";
  return fmt::format(
      "<path class=\"spread\" d=\"{}\" fill=\"none\" stroke=\"{}\" "
      "stroke-opacity=\"0.6\"/>\n",
      path, html_text(curve.colour));
}

/// The curve as lines, its error bars, and its points where they are few.
std::string curve_elements(const ChartCurve& curve, const Axes& axes, LabelPlaces& places) {
  std::string path, marks;
  const bool is_marked = curve.line == ChartLine::kNone || curve.points.size() <= kMarkedPoints;
  const ChartPoint* last = nullptr;
  for (const ChartPoint& point : curve.points) {
    if (!axes.have_place(point)) {
      last = nullptr;
      continue;
    }
    const double x = axes.x.place(point.x), y = axes.y.place(point.y);
    path += fmt::format("{}{:.1f} {:.1f}", last != nullptr ? "L" : "M", x, y);
    if (curve.line != ChartLine::kNone && last != nullptr)
      places.add_line(axes.x.place(last->x), axes.y.place(last->y), x, y);
    last = &point;
    if (!is_marked) continue;
    places.add_mark(x, y);
    marks += error_bars(curve, point, axes) +
             svg_mark(curve, x, y,
                      fmt::format("{}: {} at {}", curve.name, short_number(point.y),
                                  short_number(point.x)));
  }
  return (curve.line == ChartLine::kNone ? "" : svg_line(curve, path)) + marks;
}

std::string labels(const ChartCurve& curve, const Axes& axes, LabelPlaces& places) {
  std::string svg;
  for (const ChartPoint& point : curve.points) {
    if (point.label.empty() || !axes.have_place(point)) continue;
    const std::optional<ChartBox> box =
        places.take(axes.x.place(point.x), axes.y.place(point.y),
                    text_width(point.label, kLabelFont), kLabelFont);
    if (!box) continue;
    svg += svg_text((box->left + box->right) / 2, box->bottom - 2, "middle", point.label,
                    fmt::format(" font-size=\"{}\"", kLabelFont), {}, curve.colour);
  }
  return svg;
}

struct Drawn {
  std::string elements;  // empty: the chart has nothing to show
  double height = 0;     // units of the view box
};

Drawn drawn(const Chart& chart) {
  const std::optional<Axes> axes = axes_of(chart);
  if (!axes) return {};
  std::string svg = frame(chart, *axes);
  LabelPlaces places({axes->x.begin, axes->y.end, axes->x.end, axes->y.begin});
  std::vector<LegendEntry> legend;
  for (const ChartCurve& curve : chart.curves) {
    if (!is_drawn(curve, *axes)) continue;
    svg += curve_elements(curve, *axes, places);
    std::string words = curve.name;
    if (chart.has_last_values)
      for (auto point = curve.points.rbegin(); point != curve.points.rend(); ++point)
        if (axes->have_place(*point)) {
          words += ": " + short_number(point->y);
          break;
        }
    legend.push_back({&curve, words});
  }
  for (auto curve = chart.curves.rbegin(); curve != chart.curves.rend(); ++curve)
    svg += labels(*curve, *axes, places);
  const double top = axes->y.begin + kAxisHeight;
  const auto [elements, height] = legend_elements(legend, kLeft, top, kWidth - kRight - kLeft);
  return {svg + elements, top + height};
}

std::string svg_element(const std::string& name, double width, double height,
                        const std::string& body) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" "
      "aria-label=\"{}\" font-family=\"system-ui, sans-serif\" font-size=\"{}\" "
      "fill=\"currentColor\">\n{}</svg>\n",
      width, height, html_text(name), kFont, body);
}

}  // namespace

std::string svg_chart(const Chart& chart) {
  const Drawn one = drawn(chart);
  return one.elements.empty() ? "" : svg_element(chart.title, kWidth, one.height, one.elements);
}

std::string svg_charts(const std::string& title, const std::vector<Chart>& charts, size_t columns) {
  std::vector<Drawn> all;
  for (const Chart& chart : charts)
    if (Drawn one = drawn(chart); !one.elements.empty()) all.push_back(std::move(one));
  if (all.empty()) return "";
  columns = std::min(columns, all.size());
  const double width = double(columns) * (kWidth + kPanelGap) - kPanelGap;
  std::string svg = svg_text(kLeft, 20, "start", title, " font-weight=\"600\" font-size=\"16\"",
                             TextRoom{16, width - kLeft});
  double top = kHeading, row_height = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    if (i % columns == 0) top += std::exchange(row_height, 0);
    svg += fmt::format("<g transform=\"translate({} {:.1f})\">\n{}</g>\n",
                       double(i % columns) * (kWidth + kPanelGap), top, all[i].elements);
    row_height = std::max(row_height, all[i].height);
  }
  return svg_element(title, width, top + row_height, svg);
}

}  // namespace tessera
