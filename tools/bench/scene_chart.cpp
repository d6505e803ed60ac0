// A curve for each label, the Pareto front with its knee, and published figures, in two panels.
#include "tools/bench/scene_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ingest/files/json_file.h"
#include "kernels/base/buffer.h"
#include "kernels/base/errors.h"
#include "tools/report/svg_chart.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr const char* kFront = "currentColor";
constexpr const char* kPublished = "#808080";

constexpr ChartMetric kSeconds{"seconds"}, kPsnr{"psnr"}, kSsim{"ssim"}, kModel{"bytes", kMiB};

struct Panel {
  const char *title, *x_axis, *y_axis;
  ChartMetric x, y;
};

bool is_scored(const json& point) {
  return point.at("metrics").contains("psnr") && point.at("metrics").contains("seconds");
}

/// A curve for each label, in the order of the points.
std::vector<ChartCurve> label_curves(const json& scene, const Panel& panel,
                                     const std::string& emphasised) {
  std::vector<std::string> labels;
  std::vector<ChartCurve> curves;
  for (const json& point : scene.at("points")) {
    if (!is_scored(point)) continue;
    const std::string label = point.at("label");
    const bool is_emphasised = label == emphasised;
    const auto known = std::find(labels.begin(), labels.end(), label);
    const size_t i = size_t(known - labels.begin());
    if (known == labels.end()) {
      labels.push_back(label);
      ChartCurve& curve = curves.emplace_back();
      curve.name = label + (is_emphasised ? " (default)" : "");
      curve.colour = preset_colour(label);
      curve.width = is_emphasised ? 3.5 : 1.5;
    }
    ChartPoint& drawn = curves[i].points.emplace_back(chart_point(point, panel.x, panel.y));
    if (is_emphasised) drawn.label = point.at("iterations").dump();
  }
  return curves;
}

/// Seconds and PSNR of the points that are marked so, from the fastest on, without error bars.
ChartCurve marked_points(const json& scene, const char* key) {
  ChartCurve curve;
  curve.colour = kFront;
  for (const json& point : scene.at("points")) {
    if (!point.value(key, false)) continue;
    const ChartPoint place = chart_point(point, kSeconds, kPsnr);
    curve.points.push_back({place.x, place.y});
  }
  std::sort(curve.points.begin(), curve.points.end(),
            [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  return curve;
}

ChartCurve pareto_front(const json& scene) {
  ChartCurve front = marked_points(scene, "frontier");
  front.name = "Pareto front";
  front.line = ChartLine::kDashed;
  front.mark = ChartMark::kNone;
  front.width = 1.5;
  return front;
}

ChartCurve knee(const json& scene) {
  ChartCurve knee = marked_points(scene, "knee");
  knee.name = "knee";
  knee.line = ChartLine::kNone;
  knee.mark = ChartMark::kRing;
  for (const json& point : scene.at("points"))
    if (point.value("knee", false) && !knee.points.empty())
      knee.points.front().label = fmt::format("{}, {} steps", point.at("label").get<std::string>(),
                                              point.at("iterations").dump());
  return knee;
}

/// The entries of this scene; those that lack what the x axis shows have no place.
ChartCurve published_figures(const json& scene, const json& published, const ChartMetric& x) {
  ChartCurve curve;
  curve.name = "published, other hardware";
  curve.colour = kPublished;
  curve.line = ChartLine::kNone;
  curve.mark = ChartMark::kSquare;
  for (const json& entry : published) {
    if (entry.at("scene") != scene.at("scene") || !entry.contains(x.name)) continue;
    ChartPoint& point = curve.points.emplace_back();
    point.x = entry[x.name].get<double>() / x.unit;
    point.y = entry.at("psnr");
    point.label = fmt::format("{} ({})", entry.at("name").get<std::string>(),
                              entry.at("device").get<std::string>());
  }
  return curve;
}

Chart chart_of(const json& scene, const Panel& panel, const ImageRequest& request) {
  Chart chart{panel.title, panel.x_axis, panel.y_axis,
              label_curves(scene, panel, request.emphasised)};
  chart.logarithmic_x = true;
  chart.has_last_values = false;
  const bool is_psnr = panel.y.name == kPsnr.name;
  if (request.kind == BenchImage::kChart && panel.x.name == kSeconds.name) {
    chart.curves.push_back(pareto_front(scene));
    chart.curves.push_back(knee(scene));
  }
  if (is_psnr) chart.curves.push_back(published_figures(scene, request.published, panel.x));
  return chart;
}

/// What an entry of a file of published figures must have.
void check_published(const json& entry, const std::string& where) {
  if (!entry.is_object()) throw InputError(where + " is no object of name, scene, psnr, …");
  for (const char* key : {"name", "scene", "device"})
    if (string_at(entry, key, where).empty())
      throw InputError(fmt::format("{} has no '{}'", where, key));
  for (const char* key : {"psnr", "seconds"})
    if (!finite_number(entry, key, where))
      throw InputError(fmt::format("{} has no '{}'", where, key));
  if (*finite_number(entry, "seconds", where) <= 0)
    throw InputError(where + ": seconds must be larger than 0");
  if (finite_number(entry, "bytes", where).value_or(1) <= 0)
    throw InputError(where + ": bytes must be larger than 0");
}

void set_from(const nlohmann::json& metrics, const ChartMetric& metric, double& value,
              std::optional<ChartSpan>& span) {
  value = std::numeric_limits<double>::quiet_NaN();
  if (!metrics.contains(metric.name)) return;
  const nlohmann::json& spread = metrics[metric.name];
  const auto scaled = [&](const char* part) { return spread.at(part).get<double>() / metric.unit; };
  value = scaled("median");
  span = {scaled("least"), scaled("most")};
}

}  // namespace

bool can_be_drawn(const json& scene) {
  return std::any_of(scene.at("points").begin(), scene.at("points").end(), is_scored);
}

std::string scene_svg(const json& scene, const ImageRequest& request) {
  if (!can_be_drawn(scene)) return "";
  const Panel timed{"PSNR against training time", "training time [s]", "PSNR [dB]", kSeconds,
                    kPsnr};
  const Panel sized{"PSNR against model size", "model [MiB]", "PSNR [dB]", kModel, kPsnr};
  const Panel similar{"SSIM against training time", "training time [s]", "SSIM", kSeconds, kSsim};
  const bool is_chart = request.kind == BenchImage::kChart;
  const std::string title = fmt::format(
      "{} ({}): {}", scene.at("scene").get<std::string>(), scene.at("split").get<std::string>(),
      is_chart ? "quality against training time and size; median, least and most"
               : "quality against training time at steps of one run");
  return svg_charts(
      title,
      {chart_of(scene, timed, request), chart_of(scene, is_chart ? sized : similar, request)}, 2);
}

json read_published(const std::filesystem::path& file) {
  json entries = read_json(file);
  if (entries.is_object()) entries = json(entries.value("entries", json()));
  if (!entries.is_array())
    throw InputError(fmt::format("{}: expected an array of {{name, scene, psnr, seconds, device}}",
                                 file.string()));
  for (size_t i = 0; i < entries.size(); ++i)
    check_published(entries[i], fmt::format("{}: entry {}", file.string(), i));
  return entries;
}

ChartPoint chart_point(const nlohmann::json& point, const ChartMetric& x, const ChartMetric& y) {
  ChartPoint result;
  set_from(point.at("metrics"), x, result.x, result.x_span);
  set_from(point.at("metrics"), y, result.y, result.y_span);
  return result;
}

}  // namespace tessera
