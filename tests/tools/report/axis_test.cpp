// Ticks of linear and logarithmic axes, places along them, and numbers in few characters.
#include "tools/report/axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/report/report_pieces.h"

namespace tessera {
namespace {

using Ticks = std::vector<double>;

// Bug put back: a step that is rounded down to 1, 2 or 5, which makes up to twice as many ticks;
// seen to fail.
TEST(ChartAxes, TicksAreRoundAndFew) {
  EXPECT_EQ(axis_ticks(0, 600, 6), (Ticks{0, 100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(axis_ticks(0, 7000, 6), (Ticks{0, 2000, 4000, 6000, 8000}));
  EXPECT_EQ(axis_ticks(20, 28.3, 5), (Ticks{20, 22, 24, 26, 28, 30}));
  for (const double high : {0.003, 0.07, 1.3, 19.0, 299.0, 81234.0, 3.4e9}) {
    const Ticks ticks = axis_ticks(0, high, 5);
    EXPECT_LE(ticks.size(), 7u) << high;
    EXPECT_GE(ticks.size(), 3u) << high;
    EXPECT_GE(ticks.back(), high * (1 - 1e-6));
  }
}

// Bug put back: an empty range is not widened, and every place is NaN; seen to fail.
TEST(ChartAxes, OneValueHasARange) {
  for (const double value : {0.0, 5.0, -3.0}) {
    const Ticks ticks = axis_ticks(value, value, 5);
    EXPECT_LT(ticks.front(), value);
    EXPECT_GT(ticks.back(), value);
  }
  for (const double value : {0.02, 5.0, 7.0, 100.0}) {
    const Ticks ticks = logarithmic_ticks(value, value);
    EXPECT_LE(ticks.front(), value);
    EXPECT_GE(ticks.back(), value);
    EXPECT_LT(ticks.front(), ticks.back());
  }
}

// Bug put back: digits 1 and 5 alone; a bound that is a tick begins one tick before; powers of ten
// alone from one decade on; each seen to fail.
TEST(ChartAxes, LogarithmicTicksAreAtOneTwoAndFive) {
  EXPECT_EQ(logarithmic_ticks(1, 10), (Ticks{1, 2, 5, 10}));
  EXPECT_EQ(logarithmic_ticks(4, 400), (Ticks{2, 5, 10, 20, 50, 100, 200, 500}));
  EXPECT_EQ(logarithmic_ticks(0.03, 0.11), (Ticks{0.02, 0.05, 0.1, 0.2}));
  EXPECT_EQ(logarithmic_ticks(3, 40000), (Ticks{1, 10, 100, 1000, 10000, 100000}));
}

// Bug put back: places of a logarithmic axis by the value; seen to fail.
TEST(ChartAxes, DecadesAreEquallyLong) {
  const ChartAxis axis{{1, 10, 100, 1000}, 60, 360, true};
  EXPECT_NEAR(axis.place(10), 160, 1e-9);
  EXPECT_NEAR(axis.place(100), 260, 1e-9);
  EXPECT_FALSE(axis.has_place(0));
  EXPECT_FALSE(axis.has_place(std::nan("")));
  EXPECT_TRUE((ChartAxis{{0, 1}, 0, 1}.has_place(-1)));
}

TEST(ChartAxes, NumbersAreShort) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(28.314), "28.31");
  EXPECT_EQ(short_number(0.05), "0.05");
  EXPECT_EQ(short_number(7000), "7,000");
  EXPECT_EQ(short_number(1005), "1,005");
  EXPECT_EQ(short_number(52'032), "52k");
  EXPECT_EQ(short_number(1'234'000), "1.23M");
}

TEST(ReportPieces, NumbersHaveUnits) {
  EXPECT_EQ(time_words(3.21), "3.2 s");
  EXPECT_EQ(time_words(241.4), "4:01 min");
  EXPECT_EQ(time_words(3723), "1:02:03 h");
  EXPECT_EQ(size_words(812), "812 B");
  EXPECT_EQ(size_words(1'230'000), "1.2 MB");
}

}  // namespace
}  // namespace tessera
