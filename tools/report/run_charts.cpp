// Curves of a training as charts.
#include "tools/report/run_charts.h"

#include "tools/report/svg_chart.h"
#include "tools/report/svg_elements.h"

namespace tessera {
namespace {

std::vector<ChartPoint> points(const std::vector<CurvePoint>& curve, double unit = 1) {
  std::vector<ChartPoint> points;
  for (const CurvePoint& point : curve) points.push_back({double(point.step), point.value / unit});
  return points;
}

}  // namespace

std::vector<std::string> run_charts(const std::string& preset, const RunCurves& curves) {
  const std::string first = preset_colour(preset);
  const std::string second = first == "#D55E00" ? "#0072B2" : "#D55E00";
  const std::vector<Chart> all = {
      {"PSNR",
       "step",
       "PSNR [dB]",
       {{"test views", first, points(curves.psnr_test)},
        {"validation views", second, points(curves.psnr_validation)}}},
      {"Loss", "step", "loss", {{"training loss", first, points(curves.loss)}}, true},
      {"Gaussians",
       "step",
       "number of Gaussians",
       {{"static", first, points(curves.num_static)},
        {"dynamic", second, points(curves.num_dynamic)}},
       true},
      {"Memory",
       "step",
       "peak memory [MB]",
       {{"peak of the device", first, points(curves.bytes, 1e6)}},
       true}};
  std::vector<std::string> charts;
  for (const Chart& chart : all)
    if (std::string svg = svg_chart(chart); !svg.empty()) charts.push_back(std::move(svg));
  return charts;
}

}  // namespace tessera
