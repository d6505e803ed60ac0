// What: data blocks and plots.
// Not: any drawing of our own.
#include "tools/bench/size_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "kernels/base/byte_units.h"
#include "tools/bench/gnuplot_words.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int kMarks[] = {5, 9, 13, 11, 15};  // squares, triangles, diamonds, …

bool is_sized(const json& point) {
  return point.at("metrics").contains("psnr") && point.at("metrics").contains("shipped_bytes");
}

/// Columns: 1-3 MiB, 4-6 PSNR, 7 the share.
std::string row_of(const json& point) {
  const json& metrics = point.at("metrics");
  const std::string name =
      point.contains("share") ? fmt::format("1/{}", point["share"].get<int64_t>()) : "";
  return spread_columns(metrics, "shipped_bytes", kMiB) + spread_columns(metrics, "psnr") +
         gnuplot_datum(name) + "\n";
}

/// The points of the line, from the largest share on.
std::string budget_rows(const json& scene) {
  std::vector<const json*> points;
  for (const json& point : scene.at("points"))
    if (point.contains("share") && is_sized(point)) points.push_back(&point);
  std::sort(points.begin(), points.end(),
            [](const json* a, const json* b) { return (*a)["share"] < (*b)["share"]; });
  std::string rows;
  for (const json* point : points) rows += row_of(*point);
  return rows;
}

/// Labels of the points without a share, over all scenes.
std::vector<std::string> preset_labels(const json& scenes) {
  std::vector<std::string> labels;
  for (const json& scene : scenes) {
    for (const json& point : scene.at("points")) {
      const std::string label = point["label"];
      if (!point.contains("share") && is_sized(point) &&
          std::find(labels.begin(), labels.end(), label) == labels.end())
        labels.push_back(label);
    }
  }
  return labels;
}

std::string preset_rows(const json& scene, const std::string& label) {
  std::string rows;
  for (const json& point : scene.at("points"))
    if (!point.contains("share") && point["label"] == label && is_sized(point))
      rows += row_of(point);
  return rows;
}

constexpr const char* kPlaces = "1:4:2:3:5:6";  // of xyerrorbars

/// The blocks of a scene, and what is plotted of them.
std::string scene_blocks(const json& scene, size_t i, const std::vector<std::string>& labels,
                         std::vector<std::string>& parts) {
  const char* const colour = plot_colour(i);
  std::string blocks;
  parts.push_back(fmt::format("NaN with linespoints lc rgb '{}' lw 2 pt 7 title {}", colour,
                              gnuplot_string(scene.at("scene").get<std::string>())));
  if (const std::string rows = budget_rows(scene); !rows.empty()) {
    blocks += gnuplot_block(fmt::format("b{}", i), rows);
    parts.push_back(fmt::format("$b{} using 1:4 with lines lc rgb '{}' lw 2 notitle", i, colour));
    parts.push_back(
        fmt::format("$b{} using {} with xyerrorbars lc rgb '{}' pt 7 notitle", i, kPlaces, colour));
    parts.push_back(fmt::format(
        "$b{} using 1:4:7 with labels offset 0,-1 font ',9' tc rgb '{}' notitle", i, colour));
  }
  for (size_t l = 0; l < labels.size(); ++l) {
    const std::string rows = preset_rows(scene, labels[l]);
    if (rows.empty()) continue;
    blocks += gnuplot_block(fmt::format("p{}_{}", i, l), rows);
    parts.push_back(
        fmt::format("$p{}_{} using {} with xyerrorbars lc rgb '{}' pt {} ps 1.6 notitle", i, l,
                    kPlaces, colour, kMarks[l % std::size(kMarks)]));
  }
  return blocks;
}

}  // namespace

bool has_sizes(const json& scenes) {
  for (const json& scene : scenes)
    for (const json& point : scene.at("points"))
      if (is_sized(point)) return true;
  return false;
}

std::string size_script(const json& scenes, const std::string& stem) {
  const std::vector<std::string> labels = preset_labels(scenes);
  std::string script = "set encoding utf8\nset datafile missing 'NaN'\n";
  std::vector<std::string> parts;
  for (size_t i = 0; i < scenes.size(); ++i) script += scene_blocks(scenes[i], i, labels, parts);
  for (size_t l = 0; l < labels.size(); ++l)
    parts.push_back(fmt::format("NaN with points lc rgb 'black' pt {} ps 1.6 title {}",
                                kMarks[l % std::size(kMarks)], gnuplot_string(labels[l])));
  return script +
         both_terminals(
             stem, 1000, 700,
             fmt::format(
                 "set title {} noenhanced\n"
                 "set grid\nset logscale x\nset autoscale xfix\n{}set key outside right\n"
                 "set offsets graph 0.05, graph 0.05, graph 0.08, graph 0.08\n"
                 "set xlabel 'shipped file [MiB]'\nset ylabel 'PSNR [dB]'\nplot {}\n",
                 gnuplot_string("quality against the size of the shipped file; median, "
                                "least and most; 1/n: a share of the reference's Gaussians"),
                 logarithmic_tics(), fmt::join(parts, ", ")));
}

}  // namespace tessera
