// One panel a scene: a line through the shares, and a dot for each preset.
#include "tools/bench/size_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "kernels/base/buffer.h"
#include "tools/bench/scene_chart.h"
#include "tools/report/svg_chart.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr ChartMetric kShipped{"shipped_bytes", kMiB}, kScore{"psnr"};

bool is_sized(const json& point) {
  return point.at("metrics").contains("psnr") && point.at("metrics").contains("shipped_bytes");
}

/// The preset of a run that is limited to a share; its label continues with the share.
std::string preset_of(const json& point) {
  const std::string label = point.at("label");
  return label.substr(0, label.find("+one-in-"));
}

/// The line of shares, from the largest on.
ChartCurve share_curve(const json& scene) {
  std::vector<const json*> points;
  for (const json& point : scene.at("points"))
    if (point.contains("share") && is_sized(point)) points.push_back(&point);
  std::sort(points.begin(), points.end(),
            [](const json* a, const json* b) { return (*a)["share"] < (*b)["share"]; });
  ChartCurve curve;
  for (const json* point : points) {
    curve.name = preset_of(*point) + ", 1/n of the reference's Gaussians";
    curve.colour = preset_colour(preset_of(*point));
    ChartPoint& drawn = curve.points.emplace_back(chart_point(*point, kShipped, kScore));
    drawn.label = fmt::format("1/{}", (*point)["share"].get<int64_t>());
  }
  return curve;
}

ChartCurve preset_dot(const json& point) {
  const std::string label = point.at("label");
  ChartCurve dot{label, preset_colour(label), {chart_point(point, kShipped, kScore)}};
  dot.line = ChartLine::kNone;
  dot.width = 4;
  return dot;
}

Chart chart_of_sizes(const json& scene) {
  Chart chart;
  chart.title = fmt::format("{} ({})", scene.at("scene").get<std::string>(),
                            scene.at("split").get<std::string>());
  chart.x_axis = "shipped file [MiB]";
  chart.y_axis = "PSNR [dB]";
  chart.logarithmic_x = true;
  chart.has_last_values = false;
  chart.curves.push_back(share_curve(scene));
  for (const json& point : scene.at("points"))
    if (!point.contains("share") && is_sized(point)) chart.curves.push_back(preset_dot(point));
  return chart;
}

}  // namespace

bool has_sizes(const json& scenes) {
  for (const json& scene : scenes)
    for (const json& point : scene.at("points"))
      if (is_sized(point)) return true;
  return false;
}

std::string sizes_svg(const json& scenes) {
  std::vector<Chart> charts;
  for (const json& scene : scenes) charts.push_back(chart_of_sizes(scene));
  return svg_charts("quality against the size of the shipped file; median, least and most", charts,
                    2);
}

}  // namespace tessera
