// Groups results by scene, then by label and step.
#include "tools/batch/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

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
  const json runs = std::move(point["runs"]);
  point.erase("runs");
  point["metrics"] = json::object();
  point["errors"] = json::array();
  json done = json::array();
  for (const json& run : runs) {
    if (run.at("status") == "done") done.push_back(run);
    if (run.contains("error")) point["errors"].push_back(run["error"]);
  }
  point["n"] = done.size();
  point["devices"] = devices_of(done);
  for (const std::string& metric : point_metrics()) {
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

const std::vector<std::string>& point_metrics() {
  static const std::vector<std::string> names = {
      "psnr",        "psnr_dynamic",    "ssim",          "lpips",
      "seconds",     "command_seconds", "num_gaussians", "num_static",
      "num_dynamic", "bytes",           "shipped_bytes", "peak_device_bytes"};
  return names;
}

json points_of(const json& runs) {
  json scenes = json::array();
  for (const json& run : runs) {
    json& scene = entry_like(scenes, run, {"scene", "split"});
    json& point = entry_like(scene["points"], run, {"label", "iterations"});
    point["runs"].push_back(run);
  }
  for (json& scene : scenes)
    for (json& point : scene["points"]) summarise(point);
  return scenes;
}

std::string csv_of(const json& scenes) {
  std::vector<std::string> fields = {"scene", "split", "label", "iterations", "n"};
  for (const std::string& metric : point_metrics())
    for (const char* part : {"", "_least", "_most"}) fields.push_back(metric + part);
  fields.emplace_back("devices");
  std::string text = fmt::format("{}\n", fmt::join(fields, ","));
  for (const json& scene : scenes)
    for (const json& point : scene["points"]) {
      fields = {quoted(scene["scene"]), scene["split"], quoted(point["label"]),
                point["iterations"].dump(), point["n"].dump()};
      for (const std::string& metric : point_metrics()) {
        const json spread = point["metrics"].value(metric, json::object());
        for (const char* part : {"median", "least", "most"})
          fields.push_back(spread.contains(part) ? spread[part].dump() : "");
      }
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

}  // namespace tessera
