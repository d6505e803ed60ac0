// Charts of reports: ticks of axes, numbers, what a chart contains, and names that are no markup.
#include "tools/report/svg_chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <set>

namespace tessera {
namespace {

Chart two_curves() {
  Chart chart;
  chart.title = "PSNR";
  chart.x_axis = "step";
  chart.y_axis = "PSNR [dB]";
  chart.curves = {{"test views", "#0072B2", {{0, 20}, {300, 25.5}, {600, 28.25}}},
                  {"validation views", "#E69F00", {{300, 26}, {600, 29}}}};
  return chart;
}

/// y of all texts, and of all points of curves.
std::vector<double> numbers(const std::string& svg, const char* pattern) {
  std::vector<double> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator it(svg.begin(), svg.end(), expression), end; it != end; ++it)
    found.push_back(std::stod((*it)[1]));
  return found;
}

// Bug put back: a step that is rounded down to 1, 2 or 5, which makes up to twice as many ticks;
// seen to fail.
TEST(SvgChart, TicksAreRoundAndFew) {
  EXPECT_EQ(axis_ticks(0, 600, 6), (std::vector<double>{0, 100, 200, 300, 400, 500, 600}));
  EXPECT_EQ(axis_ticks(0, 7000, 6), (std::vector<double>{0, 2000, 4000, 6000, 8000}));
  EXPECT_EQ(axis_ticks(20, 28.3, 5), (std::vector<double>{20, 22, 24, 26, 28, 30}));
  for (const double high : {0.003, 0.07, 1.3, 19.0, 299.0, 81234.0, 3.4e9}) {
    const std::vector<double> ticks = axis_ticks(0, high, 5);
    EXPECT_LE(ticks.size(), 7u) << high;
    EXPECT_GE(ticks.size(), 3u) << high;
    EXPECT_GE(ticks.back(), high * (1 - 1e-6));
  }
}

// Bug put back: an empty range is not widened, and every place is NaN; seen to fail.
TEST(SvgChart, OneValueHasAnAxis) {
  for (const double value : {0.0, 5.0, -3.0}) {
    const std::vector<double> ticks = axis_ticks(value, value, 5);
    EXPECT_LT(ticks.front(), value);
    EXPECT_GT(ticks.back(), value);
  }
  Chart chart = two_curves();
  chart.curves = {{"one", "#000000", {{0, 7}}}};
  EXPECT_EQ(svg_chart(chart).find("nan"), std::string::npos);
}

TEST(SvgChart, NumbersAreShort) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(28.314), "28.31");
  EXPECT_EQ(short_number(0.05), "0.05");
  EXPECT_EQ(short_number(7000), "7,000");
  EXPECT_EQ(short_number(1005), "1,005");
  EXPECT_EQ(short_number(52'032), "52k");
  EXPECT_EQ(short_number(1'234'000), "1.23M");
}

TEST(SvgChart, HasAxesWithUnitsCurvesAndLastValues) {
  const std::string svg = svg_chart(two_curves());
  for (const char* part : {"<svg xmlns=", "PSNR [dB]", ">step<", "stroke=\"#0072B2\"",
                           "stroke=\"#E69F00\"", "test views: 28.25", "validation views: 29"})
    EXPECT_NE(svg.find(part), std::string::npos) << part << "\n" << svg;
  EXPECT_EQ(svg.find("<script"), std::string::npos);
}

// Bug put back: the legend at the top right within the axes; seen to fail.
TEST(SvgChart, TheLegendLiesOutsideOfThePlot) {
  const std::string svg = svg_chart(two_curves());
  const std::vector<double> curve = numbers(svg, "cy=\"([0-9.]+)\"");
  const std::vector<double> legend = numbers(svg, "<rect x=\"68\" y=\"([0-9.]+)\"");
  ASSERT_EQ(curve.size(), 5u);
  ASSERT_EQ(legend.size(), 2u);
  for (const double y : legend) EXPECT_GT(y, *std::max_element(curve.begin(), curve.end()));
}

// Bug put back: a line is drawn across a value that is not a number; seen to fail.
TEST(SvgChart, ACurveIsInterruptedWhereItHasNoValue) {
  Chart chart = two_curves();
  chart.curves.resize(1);
  chart.curves[0].points[1].y = std::nan("");
  const std::string svg = svg_chart(chart);
  EXPECT_EQ(svg.find("nan"), std::string::npos) << svg;
  const std::regex path("d=\"M[0-9. ]+M[0-9. ]+\"");
  EXPECT_TRUE(std::regex_search(svg, path)) << svg;
  chart.curves[0].points.clear();
  EXPECT_EQ(svg_chart(chart), "");
}

// Bug put back: names of curves and titles put in as they are; seen to fail.
TEST(SvgChart, NamesAreNoMarkup) {
  Chart chart = two_curves();
  chart.title = "</svg><script>alert(1)</script>";
  chart.curves[0].name = "<img src=x onerror=alert(2)>";
  chart.curves[1].colour = "red\"/><script>";
  const std::string svg = svg_chart(chart);
  EXPECT_EQ(svg.find("<script"), std::string::npos) << svg;
  EXPECT_EQ(svg.find("<img"), std::string::npos) << svg;
  EXPECT_EQ(svg.find("</svg>"), svg.size() - 7);
}

// Bug put back: colours by position in a list, so that a preset has another one beside others;
// seen to fail.
TEST(SvgChart, APresetHasOneColour) {
  std::set<std::string> colours;
  const std::vector<std::string> presets = {"fast",   "balanced", "best", "faster-gs",
                                            "yang4d", "3dgs",     "mcmc"};
  for (const std::string& preset : presets) colours.insert(preset_colour(preset));
  EXPECT_EQ(colours.size(), presets.size());
  EXPECT_EQ(preset_colour("balanced"), "#0072B2");
  EXPECT_EQ(colours.count(preset_colour("my own")), 0u);
  EXPECT_EQ(preset_colour("my own"), preset_colour("my own"));
}

}  // namespace
}  // namespace tessera
