// Headings, units and digits of each metric, and footnotes for the sources of published figures.
#include "tools/bench/table_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "kernels/base/buffer.h"

namespace tessera {
namespace {

using nlohmann::json;

struct Column {
  std::string heading, phrase;  // above a column; around a number in a sentence
  double unit = 1;
  int digits = 4;  // after the point; −1: three in all, or as many as stand before it
};

Column column_of(const std::string& metric) {
  static const std::map<std::string, Column> known = {
      {"psnr", {"PSNR dB", "{} dB", 1, 2}},
      {"ssim", {"SSIM", "SSIM {}", 1, 4}},
      {"seconds", {"training s", "{} s", 1, -1}},
      {"num_gaussians", {"Gaussians", "{} Gaussians", 1, 0}},
      {"num_static", {"static", "{} static", 1, 0}},
      {"num_dynamic", {"dynamic", "{} dynamic", 1, 0}},
      {"bytes", {"model MiB", "{} MiB", kMiB, -1}},
      {"shipped_bytes", {"shipped MiB", "{} MiB shipped", kMiB, -1}},
      {"peak_device_bytes", {"peak MiB", "{} MiB at the peak", kMiB, 0}},
      {"fps", {"frames/s", "{} frames/s", 1, 0}},
      {"psnr_0.5x", {"PSNR 0.5x", "{} dB at 0.5x", 1, 2}},
      {"psnr_1x", {"PSNR 1x", "{} dB at 1x", 1, 2}},
      {"psnr_2x", {"PSNR 2x", "{} dB at 2x", 1, 2}},
      {"ssim_0.5x", {"SSIM 0.5x", "SSIM {} at 0.5x", 1, 4}},
      {"ssim_1x", {"SSIM 1x", "SSIM {} at 1x", 1, 4}},
      {"ssim_2x", {"SSIM 2x", "SSIM {} at 2x", 1, 4}}};
  return known.at(metric);
}

std::string number(double value, const Column& column) {
  const double shown = value / column.unit;
  const int digits = column.digits >= 0 ? column.digits : shown < 10 ? 2 : shown < 100 ? 1 : 0;
  return fmt::format("{:.{}f}", shown, digits);
}

std::string spread_text(const json& metrics, const std::string& metric) {
  if (!metrics.contains(metric)) return "n/a";
  const Column column = column_of(metric);
  const json& spread = metrics[metric];
  std::string median = number(spread["median"], column);
  if (spread["count"] == 1) return median;
  return fmt::format("{} ({} to {})", median, number(spread["least"], column),
                     number(spread["most"], column));
}

/// Sources in the order in which they are cited.
struct Footnotes {
  std::vector<std::string> sources;

  size_t cite(const std::string& source) {
    const auto found = std::find(sources.begin(), sources.end(), source);
    if (found != sources.end()) return size_t(found - sources.begin()) + 1;
    sources.push_back(source);
    return sources.size();
  }
};

std::string published_text(const json& point, const std::vector<std::string>& columns,
                           Footnotes& notes) {
  std::vector<std::string> texts;
  for (const json& published : point.value("published", json::array())) {
    std::vector<std::string> figures;
    for (const std::string& metric : columns)
      if (published["figures"].contains(metric)) {
        const Column column = column_of(metric);
        figures.push_back(
            fmt::format(fmt::runtime(column.phrase), number(published["figures"][metric], column)));
      }
    texts.push_back(
        fmt::format("{} [{}]", fmt::join(figures, ", "), notes.cite(published["source"])));
  }
  return fmt::format("{}", fmt::join(texts, "; "));
}

std::string name_of(const json& point) {
  return point.contains("row") ? point["row"].get<std::string>()
                               : point["label"].get<std::string>();
}

std::string line_of(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

std::string heading(std::vector<std::string> first, const std::vector<std::string>& columns,
                    bool published) {
  for (const std::string& metric : columns) first.push_back(column_of(metric).heading);
  if (published) first.push_back("published, elsewhere");
  return line_of(first) + line_of(std::vector<std::string>(first.size(), "---"));
}

/// "frontier", "knee", what failed.
std::string remarks(const json& point) {
  std::vector<std::string> texts;
  if (point.value("knee", false))
    texts.push_back("knee");
  else if (point.value("frontier", false))
    texts.push_back("frontier");
  for (const json& error : point["errors"]) texts.push_back(error.get<std::string>());
  return fmt::format("{}", fmt::join(texts, "; "));
}

std::string scene_table(const json& scene, const std::vector<std::string>& columns,
                        bool with_published, Footnotes& notes) {
  const json& points = scene["points"];
  std::vector<std::string> devices;
  for (const json& point : points)
    for (const std::string device : point["devices"])
      if (std::find(devices.begin(), devices.end(), device) == devices.end())
        devices.push_back(device);
  std::string text = fmt::format("**{}**, split {}{}{}\n\n", scene["scene"].get<std::string>(),
                                 scene["split"].get<std::string>(), devices.empty() ? "" : ", on ",
                                 fmt::join(devices, "; "));
  const bool remarked = std::any_of(points.begin(), points.end(),
                                    [](const json& point) { return !remarks(point).empty(); });
  std::vector<std::string> first = {points[0].contains("row") ? "row" : "preset", "steps", "n"};
  if (remarked) first.push_back("remarks");
  text += heading(first, columns, with_published);
  for (const json& point : points) {
    std::vector<std::string> cells = {name_of(point), point["iterations"].dump(),
                                      point["n"].dump()};
    if (remarked) cells.push_back(remarks(point));
    for (const std::string& metric : columns)
      cells.push_back(spread_text(point["metrics"], metric));
    if (with_published) cells.push_back(published_text(point, columns, notes));
    text += line_of(cells);
  }
  return text + "\n";
}

/// Mean of a metric's medians over the scenes; nothing where a scene lacks the row or the metric.
std::optional<double> mean_over(const json& scenes, const json& like, const std::string& metric) {
  double sum = 0;
  for (const json& scene : scenes) {
    const json& points = scene["points"];
    const auto found = std::find_if(points.begin(), points.end(), [&](const json& point) {
      return name_of(point) == name_of(like) && point["iterations"] == like["iterations"];
    });
    if (found == points.end() || !(*found)["metrics"].contains(metric)) return std::nullopt;
    sum += (*found)["metrics"][metric]["median"].get<double>();
  }
  return sum / double(scenes.size());
}

std::string mean_table(const json& scenes, const std::vector<std::string>& columns) {
  std::string rows;
  for (const json& point : scenes[0]["points"]) {
    std::vector<std::string> cells = {name_of(point), point["iterations"].dump()};
    bool any = false;
    for (const std::string& metric : columns) {
      const std::optional<double> mean = mean_over(scenes, point, metric);
      cells.push_back(mean ? number(*mean, column_of(metric)) : "n/a");
      any = any || mean.has_value();
    }
    if (any) rows += line_of(cells);
  }
  if (rows.empty()) return "";
  return fmt::format("**mean of {} scenes** (of their medians)\n\n{}{}\n", scenes.size(),
                     heading({"row", "steps"}, columns, false), rows);
}

}  // namespace

void add_published(json& scenes, const BenchTable& table) {
  for (json& scene : scenes)
    for (json& point : scene["points"])
      for (const BenchRow& row : table.rows) {
        if (row.name != name_of(point)) continue;
        for (const Published& published : row.published)
          if (is_of_scene(published, scene["scene"]))
            point["published"].push_back(
                {{"source", published.source}, {"figures", published.figures}});
      }
}

std::string tables_text(const json& scenes, const std::vector<std::string>& columns) {
  bool published = false;
  for (const json& scene : scenes)
    for (const json& point : scene["points"]) published = published || point.contains("published");
  Footnotes notes;
  std::string text;
  for (const json& scene : scenes) text += scene_table(scene, columns, published, notes);
  if (scenes.size() > 1) text += mean_table(scenes, columns);
  for (size_t i = 0; i < notes.sources.size(); ++i)
    text += fmt::format("[{}] published, measured elsewhere: {}  \n", i + 1, notes.sources[i]);
  while (text.ends_with("\n")) text.pop_back();
  return text;
}

}  // namespace tessera
