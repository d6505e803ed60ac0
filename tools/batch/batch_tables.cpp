// Rows are made of the medians over the seeds of each preset.
#include "tools/batch/batch_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "tools/report/axis.h"
#include "tools/report/report_pieces.h"
#include "tools/report/svg_chart.h"
#include "tools/web/page_words.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

enum class Best { kMost, kLeast, kNone };

struct Metric {
  const char *key, *name;
  Best best;
  std::string (*words)(double);
};

std::string psnr_words(double value) {
  return fmt::format("{:.2f}", value);
}
std::string ssim_words(double value) {
  return fmt::format("{:.4f}", value);
}
std::string count_words(double value) {
  return short_number(value);
}
std::string bytes_words(double value) {
  return size_words(int64_t(value));
}

constexpr Metric kPsnr{"psnr", "PSNR [dB]", Best::kMost, psnr_words};
constexpr Metric kSeconds{"seconds", "training", Best::kLeast, time_words};
constexpr Metric kModelBytes{"bytes", "model", Best::kLeast, bytes_words};
constexpr Metric kMetrics[] = {kPsnr,
                               {"ssim", "SSIM", Best::kMost, ssim_words},
                               kSeconds,
                               {"num_gaussians", "Gaussians", Best::kNone, count_words},
                               kModelBytes,
                               {"shipped_bytes", "4D file", Best::kLeast, bytes_words},
                               {"peak_device_bytes", "peak memory", Best::kLeast, bytes_words}};

using Medians = std::vector<std::optional<double>>;  // by preset

/// In the order of the request.
std::vector<std::string> presets_of(const json& report) {
  std::vector<std::string> presets;
  for (const json& run : report["runs"]) {
    const auto& preset = run["preset"].get_ref<const std::string&>();
    if (std::find(presets.begin(), presets.end(), preset) == presets.end())
      presets.push_back(preset);
  }
  return presets;
}

/// Null where the scene has none of this preset.
json metrics_of(const json& scene, const std::string& preset) {
  for (const json& point : scene["points"])
    if (point["label"] == preset) return point["metrics"];
  return nullptr;
}

std::optional<double> median_of(const json& metrics, const char* key) {
  if (!metrics.is_object() || !metrics.contains(key)) return std::nullopt;
  return metrics[key]["median"].get<double>();
}

Medians medians_of(const json& scene, const std::vector<std::string>& presets, const char* key) {
  Medians medians;
  for (const std::string& preset : presets)
    medians.push_back(median_of(metrics_of(scene, preset), key));
  return medians;
}

/// Whether it is the best of at least two that differ.
bool is_best(const Medians& medians, size_t i, Best best) {
  if (best == Best::kNone || !medians[i]) return false;
  bool differs = false;
  for (const std::optional<double>& other : medians) {
    if (!other || *other == *medians[i]) continue;
    differs = true;
    if ((*other > *medians[i]) == (best == Best::kMost)) return false;
  }
  return differs;
}

std::string number_cell(const std::string& words, bool best, const std::string& below = "") {
  return fmt::format("<td class=\"number\">{}{}</td>",
                     best ? fmt::format("<strong>{}</strong>", words) : words,
                     below.empty() ? "" : fmt::format("<br><span class=\"soft\">{}</span>", below));
}

std::string no_cell() {
  return "<td class=\"number soft\">–</td>";
}

std::string headings(const char* first, const std::vector<std::string>& presets, bool sorts) {
  std::string html = fmt::format("<thead><tr><th{}>{}</th>", sorts ? " class=\"sort\"" : "", first);
  for (const std::string& preset : presets)
    html +=
        fmt::format("<th class=\"number{}\"><i class=\"dot\" style=\"background: {}\"></i>{}</th>",
                    sorts ? " sort" : "", preset_colour(preset), html_text(preset));
  return html + "</tr></thead>\n";
}

std::string table(const std::string& head, const std::string& rows, const std::string& foot = "") {
  return "<div class=\"wide\"><table>\n" + head + "<tbody>\n" + rows + "</tbody>\n" + foot +
         "</table></div>\n";
}

/// "23.1 s, 3.1 MB"
std::string details(const json& metrics) {
  std::string text;
  for (const Metric& metric : {kSeconds, kModelBytes})
    if (const auto value = median_of(metrics, metric.key))
      text += (text.empty() ? "" : ", ") + metric.words(*value);
  return text;
}

std::string means_row(const json& report, const std::vector<std::string>& presets) {
  Medians sums(presets.size(), 0.0);
  int64_t count = 0;
  for (const json& scene : report["scenes"]) {
    const Medians medians = medians_of(scene, presets, kPsnr.key);
    if (!std::all_of(medians.begin(), medians.end(), [](const auto& m) { return m.has_value(); }))
      continue;
    ++count;
    for (size_t i = 0; i < presets.size(); ++i) *sums[i] += *medians[i];
  }
  if (count < 2) return "";
  for (std::optional<double>& sum : sums) *sum /= double(count);
  std::string cells;
  for (size_t i = 0; i < presets.size(); ++i)
    cells += number_cell(psnr_words(*sums[i]), is_best(sums, i, kPsnr.best));
  return fmt::format("<tfoot><tr><td>mean of {} scenes</td>{}</tr></tfoot>\n", count, cells);
}

/// Of one scene and preset.
std::string runs_cell(const json& report, const json& scene, const std::string& preset) {
  int64_t done = 0, failed = 0, all = 0;
  std::string players;
  for (const json& run : report["runs"]) {
    if (run["scene"] != scene || run["preset"] != preset) continue;
    ++all;
    done += run["state"] == "done";
    failed += run["state"] == "failed";
    if (run["player"] == "") continue;
    players += fmt::format("<br><a href=\"{}\">player of seed {}</a>",
                           html_address(fs::path("..") / run["player"].get<std::string>()),
                           run["seed"].dump());
  }
  std::string html = fmt::format("{} of {}", done, all);
  if (failed > 0) html += fmt::format(", <span class=\"bad\">{} failed</span>", failed);
  return "<td class=\"number\">" + html + players + "</td>";
}

std::string metric_row(const json& scene, const std::vector<std::string>& presets,
                       const Metric& metric) {
  const Medians medians = medians_of(scene, presets, metric.key);
  if (std::none_of(medians.begin(), medians.end(), [](const auto& m) { return m.has_value(); }))
    return "";
  std::string cells;
  for (size_t i = 0; i < presets.size(); ++i) {
    if (!medians[i]) {
      cells += no_cell();
      continue;
    }
    const json spread = metrics_of(scene, presets[i])[metric.key];
    std::string range;
    if (spread["count"] > 1)
      range = fmt::format("{} to {}", metric.words(spread["least"]), metric.words(spread["most"]));
    cells += number_cell(metric.words(*medians[i]), is_best(medians, i, metric.best), range);
  }
  return fmt::format("<tr><th>{}</th>{}</tr>\n", metric.name, cells);
}

/// Steps of the trainings of one scene and preset that have scores: "60", or "60 to 150".
std::string steps_cell(const json& report, const json& scene, const std::string& preset) {
  std::set<int64_t> steps;
  for (const json& run : report["runs"])
    if (run["scene"] == scene && run["preset"] == preset && run.contains("psnr") &&
        run.contains("iterations"))
      steps.insert(run["iterations"].get<int64_t>());
  if (steps.empty()) return no_cell();
  if (steps.size() == 1) return number_cell(fmt::format("{}", *steps.begin()), false);
  return number_cell(fmt::format("{} to {}", *steps.begin(), *steps.rbegin()), false);
}

}  // namespace

std::string scenes_table(const json& report) {
  const std::vector<std::string> presets = presets_of(report);
  std::string rows;
  for (const json& scene : report["scenes"]) {
    const Medians medians = medians_of(scene, presets, kPsnr.key);
    const bool training = scene.value("split", "") == "train";
    rows += fmt::format("<tr><td>{}{}</td>", html_text(scene["scene"].get<std::string>()),
                        training ? "<br><span class=\"soft\">training views</span>" : "");
    for (size_t i = 0; i < presets.size(); ++i)
      rows += medians[i] ? number_cell(psnr_words(*medians[i]), is_best(medians, i, kPsnr.best),
                                       details(metrics_of(scene, presets[i])))
                         : no_cell();
    rows += "</tr>\n";
  }
  return table(headings("PSNR [dB]", presets, true), rows, means_row(report, presets));
}

std::string scene_table(const json& report, const json& scene) {
  const std::vector<std::string> presets = presets_of(report);
  std::string rows, steps, runs;
  for (const Metric& metric : kMetrics) rows += metric_row(scene, presets, metric);
  for (const std::string& preset : presets) {
    steps += steps_cell(report, scene["scene"], preset);
    runs += runs_cell(report, scene["scene"], preset);
  }
  rows += "<tr><th>steps</th>" + steps + "</tr>\n<tr><th>runs</th>" + runs + "</tr>\n";
  return table(headings("", presets, false), rows);
}

}  // namespace tessera
