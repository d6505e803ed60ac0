// What: data blocks, styles and panels of a gnuplot script.
// Not: any drawing of our own.
#include "tools/bench/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/byte_units.h"
#include "kernels/base/errors.h"
#include "tools/bench/gnuplot_words.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Columns: 1-3 seconds, 4-6 PSNR, 7-9 SSIM, 10-12 MiB, 13 steps; blocks $s0, $s1, … by label.
struct Series {
  std::string label, rows;
};

std::vector<Series> series_of(const json& scene) {
  std::vector<Series> all;
  for (const json& point : scene.at("points")) {
    const json& metrics = point.at("metrics");
    if (!metrics.contains("psnr") || !metrics.contains("seconds")) continue;
    const std::string label = point.at("label");
    Series* series_of_label = nullptr;
    for (Series& series : all)
      if (series.label == label) series_of_label = &series;
    if (series_of_label == nullptr) series_of_label = &all.emplace_back(Series{label, ""});
    series_of_label->rows += spread_columns(metrics, "seconds") + spread_columns(metrics, "psnr") +
                             spread_columns(metrics, "ssim") +
                             spread_columns(metrics, "bytes", kMiB) +
                             point.at("iterations").dump() + "\n";
  }
  return all;
}

/// Seconds and PSNR of the points of the frontier, from the fastest on.
std::string pareto_rows(const json& scene) {
  std::vector<std::pair<double, double>> rows;
  for (const json& point : scene.at("points"))
    if (point.value("frontier", false))
      rows.emplace_back(point["metrics"]["seconds"]["median"], point["metrics"]["psnr"]["median"]);
  std::sort(rows.begin(), rows.end());
  std::string text;
  for (const auto& [seconds, psnr] : rows) text += fmt::format("{:.10g} {:.10g}\n", seconds, psnr);
  return text;
}

/// The point of the knee: its seconds, PSNR and name; nothing without a knee.
std::string knee_row(const json& scene) {
  for (const json& point : scene.at("points"))
    if (point.value("knee", false))
      return fmt::format(
          "{:.10g} {:.10g} {}\n", point["metrics"]["seconds"]["median"].get<double>(),
          point["metrics"]["psnr"]["median"].get<double>(),
          gnuplot_datum(fmt::format("{}, {} steps", point["label"].get<std::string>(),
                                    point["iterations"].dump())));
  return "";
}

/// Seconds, PSNR, MiB, name (device) of the entries of this scene.
std::string published_rows(const json& scene, const json& published) {
  std::string rows;
  for (const json& entry : published)
    if (entry.at("scene") == scene.at("scene"))
      rows += fmt::format("{} {} {} {}\n", entry["seconds"].dump(), entry["psnr"].dump(),
                          entry.contains("bytes")
                              ? fmt::format("{:.10g}", entry["bytes"].get<double>() / kMiB)
                              : "NaN",
                          gnuplot_datum(fmt::format("{} ({})", entry["name"].get<std::string>(),
                                                    entry["device"].get<std::string>())));
  return rows;
}

struct Panel {
  const char *x_label, *y_label;
  int x, y;         // column of the median; least and most follow
  bool timed;       // frontier and knee are of seconds and PSNR
  int published_x;  // column of $published; 0: none is drawn
};

std::string plot(const Panel& panel, const std::vector<Series>& series, const ImageRequest& request,
                 bool has_knee, bool has_published) {
  std::vector<std::string> parts;
  const std::string places = fmt::format("{}:{}:{}:{}:{}:{}", panel.x, panel.y, panel.x + 1,
                                         panel.x + 2, panel.y + 1, panel.y + 2);
  for (size_t i = 0; i < series.size(); ++i) {
    const bool bold = series[i].label == request.emphasised;
    const char* colour = plot_colour(i);
    parts.push_back(fmt::format("$s{} using {}:{} with lines lc rgb '{}' lw {} notitle", i, panel.x,
                                panel.y, colour, bold ? 3 : 1));
    parts.push_back(
        fmt::format("$s{} using {} with xyerrorbars lc rgb '{}' lw {} pt 7 ps {} title {}", i,
                    places, colour, bold ? 2 : 1, bold ? 1.2 : 0.8,
                    gnuplot_string(series[i].label + (bold ? " (default)" : ""))));
    if (bold)
      parts.push_back(
          fmt::format("$s{} using {}:{}:(sprintf('%d', column(13))) with labels offset 0,-1 font "
                      "',9' tc rgb '{}' notitle",
                      i, panel.x, panel.y, colour));
  }
  if (panel.timed)
    parts.push_back("$frontier using 1:2 with lines lc rgb 'black' lw 2 dt 2 title 'frontier'");
  if (panel.timed && has_knee) {
    parts.push_back("$knee using 1:2 with points pt 6 ps 2.4 lw 2 lc rgb 'black' title 'knee'");
    parts.push_back("$knee using 1:2:3 with labels right offset -1.5,0.8 tc rgb 'black' notitle");
  }
  if (has_published && panel.published_x > 0) {
    parts.push_back(
        fmt::format("$published using {}:2 with points pt 4 ps 1.3 lw 1.5 lc rgb '#555555' title "
                    "'published, other hardware'",
                    panel.published_x));
    parts.push_back(
        fmt::format("$published using {}:2:4 with labels noenhanced right offset -1,0 font ',9' tc "
                    "rgb '#555555' notitle",
                    panel.published_x));
  }
  return fmt::format("set xlabel {}\nset ylabel {}\nplot {}\n", gnuplot_string(panel.x_label),
                     gnuplot_string(panel.y_label), fmt::join(parts, ", "));
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

}  // namespace

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

bool can_be_drawn(const json& scene) {
  return !series_of(scene).empty();
}

std::string gnuplot_script(const json& scene, const ImageRequest& request) {
  const std::vector<Series> series = series_of(scene);
  const bool chart = request.kind == BenchImage::kChart;
  const std::string published = published_rows(scene, request.published);
  const std::string knee = chart ? knee_row(scene) : "";
  std::string script = "set encoding utf8\nset datafile missing 'NaN'\n";
  for (size_t i = 0; i < series.size(); ++i)
    script += gnuplot_block(fmt::format("s{}", i), series[i].rows);
  if (chart) script += gnuplot_block("frontier", pareto_rows(scene));
  if (!knee.empty()) script += gnuplot_block("knee", knee);
  if (!published.empty()) script += gnuplot_block("published", published);
  const Panel left{"training seconds", "PSNR [dB]", 1, 4, chart, 1};
  const Panel right = chart ? Panel{"model [MiB]", "PSNR [dB]", 10, 4, false, 3}
                            : Panel{"training seconds", "SSIM", 1, 7, false, 0};
  const std::string title = fmt::format(
      "{} ({}): {}", scene.at("scene").get<std::string>(), scene.at("split").get<std::string>(),
      chart ? "quality against training time and size; median, least and most"
            : "quality against training time at steps of one run");
  return script +
         both_terminals(
             request.stem, 1400, 600,
             fmt::format("set multiplot layout 1,2 title {} noenhanced\n"
                         "set grid\nset logscale x\nset autoscale xfix\n{}set key bottom right\n"
                         "set offsets graph 0.05, graph 0.1, graph 0.08, graph 0.05\n"
                         "{}{}unset multiplot\n",
                         gnuplot_string(title), logarithmic_tics(),
                         plot(left, series, request, !knee.empty(), !published.empty()),
                         plot(right, series, request, false, !published.empty())));
}

}  // namespace tessera
