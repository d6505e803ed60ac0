// Charts of reports: the elements of a chart and their positions, and escaped names.
#include "tools/report/svg_chart.h"

#include <gtest/gtest.h>

#include <algorithm>
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

/// The first number that is caught by each match, in the order of the text.
std::vector<double> numbers(const std::string& svg, const char* pattern) {
  std::vector<double> found;
  const std::regex expression(pattern);
  for (std::sregex_iterator it(svg.begin(), svg.end(), expression), end; it != end; ++it)
    found.push_back(std::stod((*it)[1]));
  return found;
}

// Bug put back: an empty range is not widened, and every place is NaN; seen to fail.
TEST(SvgChart, OneValueIsDrawn) {
  Chart chart = two_curves();
  chart.curves = {{"one", "#000000", {{0, 7}}}};
  EXPECT_EQ(svg_chart(chart).find("nan"), std::string::npos);
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
  const std::vector<double> legend = numbers(svg, "y=\"([0-9.]+)\"[^>]*>[a-z]+ views: ");
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

/// 1 to 1000 on a logarithmic axis: the plot begins at 68 and ends at 458.
Chart logarithmic() {
  Chart chart;
  chart.title = "lego (test)";
  chart.x_axis = "training time [s]";
  chart.y_axis = "PSNR [dB]";
  chart.logarithmic_x = true;
  chart.has_last_values = false;
  chart.curves = {{"fast", "#E69F00", {{1, 20}, {10, 25}, {1000, 30}}}};
  return chart;
}

// Bug put back: a point at x ≤ 0 makes the axis begin there; seen to fail.
TEST(SvgChart, ALogarithmicAxisHasEqualDecades) {
  Chart chart = logarithmic();
  chart.curves[0].points.insert(chart.curves[0].points.begin(), {0, 10});
  const std::string svg = svg_chart(chart);
  const std::vector<double> x = numbers(svg, "cx=\"([0-9.]+)\"");
  ASSERT_EQ(x.size(), 3u) << svg;
  EXPECT_NEAR(x[0], 68, 0.1);
  EXPECT_NEAR(x[1], 68 + 390 / 3.0, 0.1);
  EXPECT_NEAR(x[2], 458, 0.1);
  for (const char* tick : {">1<", ">2<", ">5<", ">10<", ">100<", ">1,000<"})
    EXPECT_NE(svg.find(tick), std::string::npos) << tick;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

// Bugs put back, each seen to fail: numbers of ticks are all drawn, however near; the first of two
// that touch has precedence, not the power of ten.
TEST(SvgChart, NumbersOfTicksDoNotTouch) {
  Chart chart = logarithmic();
  chart.curves[0].points = {{190, 20}, {180'000, 25}};  // 3.3 decades of 118 each
  const std::string svg = svg_chart(chart);
  for (const char* power : {">100<", ">1,000<", ">10k<", ">100k<"})
    EXPECT_NE(svg.find(power), std::string::npos) << power;
  EXPECT_NE(svg.find(">200<"), std::string::npos) << "it has room";
  for (const char* near : {">2,000<", ">5,000<"})
    EXPECT_EQ(svg.find(near), std::string::npos) << near;
}

// Bugs put back, each seen to fail: bars from the median to the most alone; a range without the
// bars; bars where all seeds agree.
TEST(SvgChart, ErrorBarsGoFromLeastToMost) {
  Chart chart = logarithmic();
  chart.curves[0].points = {{1, 20},
                            {10, 25, ChartSpan{1, 100}, ChartSpan{20, 40}},
                            {100, 22, ChartSpan{100, 100}, ChartSpan{22, 22}}};
  const std::string svg = svg_chart(chart);
  EXPECT_EQ(numbers(svg, "class=\"spread\" d=\"M([0-9.]+)").size(), 1u) << svg;
  // x: 1 to 100 s are the whole axis; y: 20 to 40 dB are the whole axis, 25 dB is a quarter
  const std::string bars = "M68.0 191.5H458.0M68.0 188.5v6M458.0 188.5v6M263.0 244.0V34.0";
  EXPECT_NE(svg.find(bars), std::string::npos) << svg;
}

// Bug put back: a bar to a bound that a logarithmic axis has no place for; seen to fail.
TEST(SvgChart, ABarWithoutAPlaceIsLeftOut) {
  Chart chart = logarithmic();
  chart.curves[0].points[1].x_span = ChartSpan{-1, 20};
  const std::string svg = svg_chart(chart);
  EXPECT_EQ(svg.find("class=\"spread\""), std::string::npos) << svg;
  EXPECT_EQ(svg.find("nan"), std::string::npos) << svg;
}

// Bugs put back, each seen to fail: the legend shows a solid line for each curve; a curve without a
// line has one.
TEST(SvgChart, LinesAndMarksAreInThePlotAndTheLegend) {
  Chart chart = logarithmic();
  chart.curves.push_back(
      {"front", "currentColor", {{1, 20}, {1000, 30}}, ChartLine::kDashed, ChartMark::kNone});
  chart.curves.push_back({"knee", "currentColor", {{10, 25}}, ChartLine::kNone, ChartMark::kRing});
  chart.curves.push_back(
      {"published", "#808080", {{100, 28}}, ChartLine::kNone, ChartMark::kSquare});
  chart.curves.push_back({"none measured", "#808080", {{std::nan(""), 28}}});
  const std::string svg = svg_chart(chart);
  const auto plot_and_legend = [&](const char* pattern, const char* what) {
    const std::vector<double> y = numbers(svg, pattern);
    ASSERT_EQ(y.size(), 2u) << what << "\n" << svg;
    EXPECT_LT(y[0], 245) << what;
    EXPECT_GT(y[1], 285) << what;
  };
  plot_and_legend("<path d=\"M[0-9.]+ ([0-9.]+)[^>]*stroke-dasharray", "dashed line");
  plot_and_legend("cy=\"([0-9.]+)\" r=\"7.5\" fill=\"none\"", "ring");
  plot_and_legend("<rect x=\"[0-9.]+\" y=\"([0-9.]+)\"[^>]* fill=\"none\"", "square");
  EXPECT_EQ(numbers(svg, "<path d=\"M([0-9.]+)").size(), 4u) << "two lines, in plot and legend";
  for (const char* name : {">fast<", ">front<", ">knee<", ">published<"})
    EXPECT_NE(svg.find(name), std::string::npos) << name;
  EXPECT_EQ(svg.find("none measured"), std::string::npos) << "it has no point";
}

// Bugs put back, each seen to fail: labels centred on their points; a label covers the dot of
// another point.
TEST(SvgChart, LabelsStandBesideDots) {
  Chart chart = logarithmic();
  // the last dot is where the label of the second would be
  chart.curves[0].points = {{1, 30}, {10, 25}, {10.2, 24.65}};
  chart.curves[0].line = ChartLine::kNone;
  chart.curves[0].points[1].label = "label";
  const std::string svg = svg_chart(chart);
  const double x = numbers(svg, "x=\"([0-9.]+)\" y=\"[0-9.]+\"[^>]*>label<").at(0);
  const double y = numbers(svg, "y=\"([0-9.]+)\"[^>]*>label<").at(0);
  const std::vector<double> dot_x = numbers(svg, "cx=\"([0-9.]+)\"");
  const std::vector<double> dot_y = numbers(svg, "cy=\"([0-9.]+)\"");
  for (size_t i = 0; i < 3; ++i)  // five letters of 11 units, on their baseline
    EXPECT_TRUE(std::abs(dot_x[i] - x) > 16 || dot_y[i] > y + 2 || dot_y[i] < y - 9) << i << svg;
}

// Bug put back: a label that has no room is drawn over the others; seen to fail.
TEST(SvgChart, LabelsDoNotCoverEachOther) {
  Chart chart = logarithmic();
  chart.curves[0].points.clear();
  for (int i = 0; i < 40; ++i) chart.curves[0].points.push_back({10 + i * 0.01, 25});
  for (ChartPoint& point : chart.curves[0].points) point.label = "3000 steps";
  chart.curves[0].line = ChartLine::kNone;
  chart.curves.push_back({"ends", "#000000", {{1, 20}, {1000, 30}}});
  const std::string svg = svg_chart(chart);
  const std::string place = "x=\"([0-9.]+)\" y=\"[0-9.]+\"[^>]*>3000 steps<";
  const std::vector<double> x = numbers(svg, place.c_str());
  const std::vector<double> y = numbers(svg, "y=\"([0-9.]+)\"[^>]*>3000 steps<");
  ASSERT_GE(x.size(), 2u);
  ASSERT_LT(x.size(), 40u) << "there is no room for all";
  for (size_t a = 0; a < x.size(); ++a)
    for (size_t b = 0; b < a; ++b)
      EXPECT_TRUE(std::abs(x[a] - x[b]) > 60 || std::abs(y[a] - y[b]) >= 11) << a << " " << b;
}

// Bugs put back, each seen to fail: all panels at the same place; an empty panel keeps its place.
TEST(SvgChart, ChartsStandSideBySide) {
  Chart empty = two_curves();
  empty.curves.clear();
  const std::string svg = svg_charts("a & b", {two_curves(), empty, logarithmic()}, 2);
  EXPECT_NE(svg.find("viewBox=\"0 0 1000 "), std::string::npos) << svg;
  EXPECT_NE(svg.find(">a &amp; b<"), std::string::npos) << svg;
  EXPECT_NE(svg.find("translate(0 30.0)"), std::string::npos) << svg;
  EXPECT_NE(svg.find("translate(520 30.0)"), std::string::npos) << svg;
  EXPECT_EQ(numbers(svg, "<svg[^>]*viewBox=\"([0-9])").size(), 1u);
  EXPECT_EQ(svg_charts("none", {empty}, 2), "");
  const std::string below = svg_charts("rows", {two_curves(), two_curves(), two_curves()}, 2);
  const std::vector<double> tops = numbers(below, "translate\\(0 ([0-9.]+)\\)");
  ASSERT_EQ(tops.size(), 2u);
  EXPECT_GT(tops[1], 300);
}

// Bugs put back, each seen to fail: all entries in one column; a long name beside another entry.
TEST(SvgChart, ALongNameHasARowAlone) {
  Chart chart = logarithmic();
  const std::vector<ChartPoint> points = chart.curves[0].points;
  chart.curves.clear();
  for (const char* name : {"one", "a name that is longer than a column", "two", "three"})
    chart.curves.push_back({name, "#000000", points});
  const std::string svg = svg_chart(chart);
  const auto row = [&](const std::string& name) {
    return numbers(svg, ("y=\"([0-9.]+)\"[^>]*>" + name + "<").c_str()).at(0);
  };
  EXPECT_GT(row("a name that is longer than a column"), row("one"));
  EXPECT_GT(row("two"), row("a name that is longer than a column"));
  EXPECT_EQ(row("two"), row("three"));
}

// Bug put back: a long title reaches beyond the image; seen to fail.
TEST(SvgChart, ALongTitleIsSqueezed) {
  Chart chart = two_curves();
  EXPECT_EQ(svg_chart(chart).find("textLength"), std::string::npos);
  chart.title = std::string(80, 'w');
  EXPECT_NE(svg_chart(chart).find("textLength=\"412\""), std::string::npos);
}

// Bug put back: names of curves, titles and labels put in as they are; each seen
// to fail.
TEST(SvgChart, NamesAreNoMarkup) {
  Chart chart = two_curves();
  chart.title = "</svg><script>alert(1)</script>";
  chart.curves[0].name = "<img src=x onerror=alert(2)>";
  chart.curves[1].colour = "red\"/><script>";
  chart.curves[1].points[0].label = "<script>";
  chart.curves[1].points[0].y_span = ChartSpan{20, 27};
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
