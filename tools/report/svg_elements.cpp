// Texts, lines and marks of charts; names and colours are escaped here.
#include "tools/report/svg_elements.h"

#include <fmt/format.h>

#include "tools/player/page_words.h"
#include "tools/report/chart_labels.h"

namespace tessera {

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

}  // namespace tessera
