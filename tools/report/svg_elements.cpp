// Texts, lines, marks and legends of charts; names and colours are escaped here.
#include "tools/report/svg_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "tools/report/chart_labels.h"
#include "tools/report/svg_chart.h"
#include "tools/web/page_words.h"

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

struct PresetColour {
  std::string_view preset, colour;
};

constexpr std::array<PresetColour, 7> kPresets = {{{"fast", "#E69F00"},
                                                   {"balanced", "#0072B2"},
                                                   {"best", "#009E73"},
                                                   {"faster-gs", "#D55E00"},
                                                   {"yang4d", "#CC79A7"},
                                                   {"3dgs", "#56B4E9"},
                                                   {"mcmc", "#8A6FBF"}}};

constexpr std::array<std::string_view, 4> kOthers = {"#7F7F7F", "#A6761D", "#666699", "#5F8F4F"};

}  // namespace

std::string svg_text(double x, double y, const char* anchor, const std::string& words,
                     const std::string& more, std::optional<TextRoom> room,
                     const std::string& colour) {
  std::string attributes = more;
  if (!colour.empty()) attributes += fmt::format(" fill=\"{}\"", html_text(colour));
  if (room && text_width(words, room->font_size) > room->width)
    attributes +=
        fmt::format(" textLength=\"{:.0f}\" lengthAdjust=\"spacingAndGlyphs\"", room->width);
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, attributes, html_text(words));
}

std::string svg_line(const ChartCurve& curve, const std::string& path) {
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{}"
      "/>\n",
      path, html_text(curve.colour), curve.width,
      curve.line == ChartLine::kDashed ? " stroke-dasharray=\"6 4\"" : "");
}

std::string svg_mark(const ChartCurve& curve, double x, double y, const std::string& tooltip) {
  const std::string colour = html_text(curve.colour);
  const std::string inside =
      tooltip.empty() ? "" : fmt::format("<title>{}</title>", html_text(tooltip));
  switch (curve.mark) {
    case ChartMark::kDot:
      return fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"{}\">{}</circle>\n", x, y,
          2.2 + curve.width / 2, colour, inside);
    case ChartMark::kRing:
      return fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7.5\" fill=\"none\" stroke=\"{}\" "
          "stroke-width=\"2\">{}</circle>\n",
          x, y, colour, inside);
    case ChartMark::kSquare:
      return fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"8\" height=\"8\" fill=\"none\" stroke=\"{}\" "
          "stroke-width=\"1.5\">{}</rect>\n",
          x - 4, y - 4, colour, inside);
    case ChartMark::kNone:
      break;
  }
  return "";
}

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

std::string preset_colour(std::string_view preset) {
  for (const PresetColour& known : kPresets)
    if (known.preset == preset) return std::string(known.colour);
  uint32_t sum = 0;
  for (const char c : preset) sum = sum * 31 + uint8_t(c);
  return std::string(kOthers[sum % kOthers.size()]);
}

}  // namespace tessera
