// Each label tries places around its point and takes the first that covers least.
#include "tools/report/chart_labels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tessera {
namespace {

constexpr double kLabelGap = 7;   // from the point to its label
constexpr double kMarkRoom = 4;   // half the side of a mark's box
constexpr double kLineStep = 6;   // lines are taken as small boxes this far apart
constexpr double kLineRoom = 1;   // half the side of these
constexpr int kMarkCosts = 3;     // a covered mark is worse than a piece of a line
constexpr double kLetter = 0.58;  // mean width of a letter, of the font size

ChartBox around(double x, double y, double room) {
  return {x - room, y - room, x + room, y + room};
}

}  // namespace

double text_width(std::string_view text, double font_size) {
  const auto begins = [](char c) { return (uint8_t(c) & 0xC0) != 0x80; };  // of UTF-8 characters
  return double(std::count_if(text.begin(), text.end(), begins)) * kLetter * font_size;
}

bool ChartBox::overlaps(const ChartBox& other) const {
  return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
}

bool ChartBox::contains(const ChartBox& other) const {
  return left <= other.left && other.right <= right && top <= other.top && other.bottom <= bottom;
}

void LabelPlaces::add_mark(double x, double y) {
  marks_.push_back(around(x, y, kMarkRoom));
}

void LabelPlaces::add_line(double x1, double y1, double x2, double y2) {
  const int steps = std::max(1, int(std::hypot(x2 - x1, y2 - y1) / kLineStep));
  for (int i = 0; i <= steps; ++i)
    lines_.push_back(around(x1 + (x2 - x1) * i / steps, y1 + (y2 - y1) * i / steps, kLineRoom));
}

int LabelPlaces::covered(const ChartBox& box) const {
  int sum = 0;
  for (const ChartBox& mark : marks_) sum += kMarkCosts * int(box.overlaps(mark));
  for (const ChartBox& line : lines_) sum += int(box.overlaps(line));
  return sum;
}

std::optional<ChartBox> LabelPlaces::take(double x, double y, double width, double height) {
  std::optional<ChartBox> best;
  int least = 0;
  for (const double gap : {kLabelGap, 2 * kLabelGap, 3 * kLabelGap})
    for (const double down : {1.0, -1.0, 0.0})       // below, above, beside
      for (const double right : {0.0, -1.0, 1.0}) {  // centred, to the left, to the right
        if (down == 0 && right == 0) continue;
        const double middle_x = x + right * (width / 2 + gap);
        const double middle_y = y + down * (height / 2 + (right == 0 ? gap : gap / 2));
        const ChartBox box{middle_x - width / 2, middle_y - height / 2, middle_x + width / 2,
                           middle_y + height / 2};
        const auto hits = [&](const ChartBox& label) { return box.overlaps(label); };
        if (!plot_.contains(box) || std::any_of(labels_.begin(), labels_.end(), hits)) continue;
        const int costs = covered(box);
        if (best && costs >= least) continue;
        best = box;
        least = costs;
      }
  if (best) labels_.push_back(*best);
  return best;
}

}  // namespace tessera
