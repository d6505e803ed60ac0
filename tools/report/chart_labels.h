// Places for short labels beside the points of a chart, so that they do not cover each other.
#pragma once
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace tessera {

/// About how wide a text is in a sans-serif font, in the unit of the font size; no font is read.
double text_width(std::string_view text, double font_size);

/// A rectangle of the view box, y downwards.
struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;

  bool overlaps(const ChartBox& other) const;
  bool contains(const ChartBox& other) const;
};

/// What a plot holds already: marks and lines, which a label should not cover, and labels, which
/// it must not.
class LabelPlaces {
 public:
  explicit LabelPlaces(const ChartBox& plot) : plot_(plot) {}

  void add_mark(double x, double y);
  void add_line(double x1, double y1, double x2, double y2);

  /// The box of a label of this size beside the point (x, y), within the plot, where it covers
  /// least; it is taken then. Nothing where each place would cover another label.
  std::optional<ChartBox> take(double x, double y, double width, double height);

 private:
  /// How much a label would cover there.
  int covered(const ChartBox& box) const;

  ChartBox plot_;
  std::vector<ChartBox> marks_, lines_, labels_;
};

}  // namespace tessera
