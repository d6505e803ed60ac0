// Groups results by scene, then by label and step.
#include "tools/bench/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

/// The element of an array of objects whose `keys` are those of `like`; made when there is none.
json& entry_like(json& array, const json& like, const std::vector<const char*>& keys) {
  for (json& entry : array)
    if (std::all_of(keys.begin(), keys.end(),
                    [&](const char* key) { return entry[key] == like.at(key); }))
      return entry;
  array.push_back(json::object());
  for (const char* key : keys) array.back()[key] = like.at(key);
  return array.back();
}

json to_json(const Spread& spread) {
  return {{"median", spread.median},
          {"least", spread.least},
          {"most", spread.most},
          {"count", spread.count}};
}

/// Of a point whose `runs` are gathered: their spreads.
void summarise(json& point) {
  const json runs = std::move(point["cells"]);
  point.erase("cells");
  for (const char* key : {"row", "share"})
    if (runs[0].contains(key)) point[key] = runs[0][key];
  point["metrics"] = json::object();
  point["errors"] = json::array();
  json done = json::array();
  for (const json& run : runs) {
    if (run.at("status") == "done") done.push_back(run);
    if (run.contains("error")) point["errors"].push_back(run["error"]);
  }
  point["n"] = done.size();
  point["devices"] = devices_of(done);
  for (const std::string& metric : bench_metrics()) {
    std::vector<double> values;
    for (const json& run : done)
      if (run["metrics"].contains(metric) && run["metrics"][metric].is_number())
        values.push_back(run["metrics"][metric].get<double>());
    if (const std::optional<Spread> spread = spread_of(values))
      point["metrics"][metric] = to_json(*spread);
  }
}

/// A field of CSV (RFC 4180).
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string inside;
  for (char c : text) inside += c == '"' ? std::string("\"\"") : std::string(1, c);
  return '"' + inside + '"';
}

}  // namespace

const std::vector<std::string>& bench_metrics() {
  static const std::vector<std::string> names = {"psnr",
                                                 "ssim",
                                                 "psnr_float",
                                                 "seconds",
                                                 "load_seconds",
                                                 "evaluate_seconds",
                                                 "bytes",
                                                 "shipped_bytes",
                                                 "num_gaussians",
                                                 "num_static",
                                                 "num_dynamic",
                                                 "fps",
                                                 "peak_device_bytes",
                                                 "psnr_0.5x",
                                                 "psnr_1x",
                                                 "psnr_2x",
                                                 "ssim_0.5x",
                                                 "ssim_1x",
                                                 "ssim_2x"};
  return names;
}

json bench_points(const json& runs) {
  json scenes = json::array();
  for (const json& run : runs) {
    json& scene = entry_like(scenes, run, {"scene", "split"});
    json& point = entry_like(scene["points"], run, {"label", "iterations"});
    point["cells"].push_back(run);
  }
  for (json& scene : scenes)
    for (json& point : scene["points"]) summarise(point);
  return scenes;
}

json curve_runs(const json& runs) {
  json steps = json::array();
  for (const json& run : runs) {
    if (!run.contains("curve")) {
      steps.push_back(run);
      continue;
    }
    for (const json& step : run["curve"]) {
      json one = run;
      one.erase("curve");
      one["iterations"] = step.at("iteration");
      one["metrics"] = step;
      steps.push_back(std::move(one));
    }
  }
  return steps;
}

void mark_pareto_front(json& scenes) {
  for (json& scene : scenes) {
    std::vector<TimedScore> scores;
    std::vector<json*> points;
    for (json& point : scene["points"]) {
      point["frontier"] = point["knee"] = false;
      const json& metrics = point["metrics"];
      if (!metrics.contains("psnr") || !metrics.contains("seconds")) continue;
      const double seconds = metrics["seconds"]["median"];
      if (!(seconds > 0)) continue;
      scores.push_back({seconds, metrics["psnr"]["median"]});
      points.push_back(&point);
    }
    for (size_t i : pareto_front_of(scores)) (*points[i])["frontier"] = true;
    if (const std::optional<size_t> knee = knee_of(scores)) (*points[*knee])["knee"] = true;
  }
}

std::string csv_of(const json& scenes) {
  std::vector<std::string> fields = {"scene", "split", "label", "iterations", "n"};
  for (const std::string& metric : bench_metrics())
    for (const char* part : {"", "_least", "_most"}) fields.push_back(metric + part);
  for (const char* name : {"frontier", "knee", "devices"}) fields.push_back(name);
  std::string text = fmt::format("{}\n", fmt::join(fields, ","));
  for (const json& scene : scenes)
    for (const json& point : scene["points"]) {
      fields = {quoted(scene["scene"]), scene["split"], quoted(point["label"]),
                point["iterations"].dump(), point["n"].dump()};
      for (const std::string& metric : bench_metrics()) {
        const json spread = point["metrics"].value(metric, json::object());
        for (const char* part : {"median", "least", "most"})
          fields.push_back(spread.contains(part) ? spread[part].dump() : "");
      }
      for (const char* mark : {"frontier", "knee"})
        fields.push_back(point.contains(mark) ? point[mark].dump() : "");
      const std::vector<std::string> devices = point["devices"];
      fields.push_back(quoted(fmt::format("{}", fmt::join(devices, "; "))));
      text += fmt::format("{}\n", fmt::join(fields, ","));
    }
  return text;
}

std::vector<std::string> devices_of(const json& runs) {
  std::set<std::string> devices;
  for (const json& run : runs)
    if (run.contains("device")) devices.insert(run["device"].get<std::string>());
  return {devices.begin(), devices.end()};
}

std::optional<Spread> spread_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return Spread{0.5 * (values[(n - 1) / 2] + values[n / 2]), values.front(), values.back(),
                int64_t(n)};
}

std::vector<size_t> pareto_front_of(const std::vector<TimedScore>& points) {
  std::vector<size_t> order(points.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return points[a].seconds != points[b].seconds ? points[a].seconds < points[b].seconds
                                                  : points[a].psnr > points[b].psnr;
  });
  std::vector<size_t> frontier;
  for (size_t i : order)
    if (frontier.empty() || points[i].psnr > points[frontier.back()].psnr) frontier.push_back(i);
  return frontier;
}

std::optional<size_t> knee_of(const std::vector<TimedScore>& points) {
  for (const TimedScore& point : points)
    check(point.seconds > 0, "knee_of: a logarithm of seconds > 0");
  const std::vector<size_t> frontier = pareto_front_of(points);
  if (frontier.size() < 3) return std::nullopt;
  const TimedScore &first = points[frontier.front()], &last = points[frontier.back()];
  const double time = std::log(last.seconds / first.seconds), gain = last.psnr - first.psnr;
  std::optional<size_t> knee;
  double farthest = 0;
  for (size_t i : frontier) {
    // the line is y = x; the distance from it is (y − x) / √2
    const double x = std::log(points[i].seconds / first.seconds) / time;
    const double y = (points[i].psnr - first.psnr) / gain;
    if (y - x > farthest) {
      farthest = y - x;
      knee = i;
    }
  }
  return knee;
}

}  // namespace tessera
