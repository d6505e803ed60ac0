// The sections of the page of a run, from the most important to the details.
#include "tools/report/report_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/report/axis.h"
#include "tools/report/camera_section.h"
#include "tools/report/report_pieces.h"
#include "tools/web/page_words.h"

namespace tessera {
namespace {

std::string views_words(const std::string& split) {
  if (split == "train") return "training views, as nothing is held out";
  return split == "val" ? "validation views" : "test views";
}

/// "2026-11-24 09:30 UTC" of what utc_time gives; other text as it is.
std::string date_words(const std::string& time) {
  if (time.size() != 20 || time[10] != 'T' || time.back() != 'Z') return time;
  return time.substr(0, 10) + " " + time.substr(11, 5) + " UTC";
}

std::string head(const RunPage& page) {
  const RunReport& report = page.report;
  std::string summary = fmt::format("{} steps", short_number(double(report.steps)));
  if (!report.preset.empty()) summary += fmt::format(", preset {}", report.preset);
  if (!report.started.empty()) summary += fmt::format(", started {}", date_words(report.started));
  std::string links;
  for (const ReportLink& link : page.links)
    links += fmt::format("<a{} href=\"{}\">{}</a>\n", links.empty() ? " class=\"first\"" : "",
                         link.address, html_text(link.name));
  return fmt::format("<h1>{}</h1>\n<p class=\"soft\">{}</p>\n<nav class=\"links\">\n{}</nav>\n",
                     html_text(page.title), html_text(summary), links);
}

std::string score_tile(const std::string& name, const std::string& value) {
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", html_text(name), html_text(value));
}

std::string scores(const RunPage& page) {
  const RunReport& report = page.report;
  std::string tiles;
  for (const RunScore& score : report.scores) tiles += score_tile(score.name, score.value);
  tiles += score_tile("Static Gaussians", short_number(double(report.num_static)));
  tiles += score_tile("Dynamic Gaussians", short_number(double(report.num_dynamic)));
  for (const ReportLink& link : page.links)
    if (link.bytes >= 0 && link.name == "Model")
      tiles += score_tile("Model", size_words(link.bytes));
  std::string note;
  if (!report.views.empty())
    note = fmt::format("<p class=\"soft\">Scores are means over {} {}.</p>\n", report.views.size(),
                       views_words(report.split));
  return "<dl class=\"scores\">\n" + tiles + "</dl>\n" + note;
}

std::string warnings(const RunReport& report) {
  if (report.warnings.empty()) return "";
  std::string items;
  for (const RunWarning& warning : report.warnings)
    items += fmt::format("<li><strong>{}</strong>: {}</li>\n", html_text(warning.stage),
                         html_text(warning.text));
  return "<h2>Warnings</h2>\n<div class=\"card warnings\"><ul>\n" + items + "</ul></div>\n";
}

std::string telling(const RunPage& page) {
  if (!page.image_note.empty())
    return fmt::format("<h2>Views</h2>\n<p class=\"soft\">{}</p>\n", html_text(page.image_note));
  if (page.images.telling.empty()) return "";
  std::string html = "<h2>Worst, median and best view</h2>\n" + error_scale();
  html += "<p class=\"soft\">Drag the line between truth and result.</p>\n";
  for (const ShownView& view : page.images.telling) html += compared_view(view);
  return html;
}

std::string strips(const RunImages& images) {
  if (images.strips.empty()) return "";
  std::string html = "<h2>Over time, by camera</h2>\n" + error_scale();
  for (const CameraStrip& strip : images.strips) html += camera_strip(strip);
  return html;
}

std::string charts(const RunReport& report) {
  std::string html;
  for (const auto& [name, svg] : run_charts(report))
    html += "<div class=\"card\">" + svg + "</div>\n";
  return html.empty() ? "" : "<h2>Training</h2>\n<div class=\"charts\">\n" + html + "</div>\n";
}

std::string decisions(const RunReport& report) {
  if (report.decisions.empty()) return "";
  std::string items;
  for (const RunDecision& decision : report.decisions)
    items += fmt::format("<li><strong>Step {}.</strong> {}</li>\n",
                         short_number(double(decision.step)), html_text(decision.text));
  return "<h2>What the training decided</h2>\n<div class=\"card\"><ol class=\"decisions\">\n" +
         items + "</ol></div>\n";
}

std::string stages(const RunReport& report) {
  double all = 0, longest = 0;
  for (const StageTime& stage : report.stages) {
    all += stage.seconds;
    longest = std::max(longest, stage.seconds);
  }
  if (longest <= 0) return "";
  std::string bars;
  for (const StageTime& stage : report.stages)
    bars += fmt::format("<span>{}</span><i style=\"width: {:.1f}%\"></i><b>{}</b>\n",
                        html_text(stage.name), 100 * stage.seconds / longest,
                        time_words(stage.seconds));
  return fmt::format(
      "<div class=\"card\"><h3>Time, {} in all</h3>\n<div class=\"bars\">\n{}</div>"
      "</div>\n",
      time_words(all), bars);
}

std::string files(const RunPage& page) {
  std::string rows;
  for (const ReportLink& link : page.links)
    rows += fact_html(link.name,
                      fmt::format("<a href=\"{0}\">{0}</a>{1}", link.address,
                                  link.bytes < 0 ? "" : " (" + size_words(link.bytes) + ")"));
  return rows.empty() ? ""
                      : "<div class=\"card\"><h3>Files</h3>\n<dl class=\"facts\">\n" + rows +
                            "</dl></div>\n";
}

std::string machine(const RunReport& report) {
  std::string rows = fact("version", report.version) + fact("preset", report.preset) +
                     fact("started", date_words(report.started)) + fact("device", report.device) +
                     fact("processor", report.cpu) + fact("host", report.host);
  if (!report.command.empty())
    rows += fact_html("command", "<code>" + html_text(report.command) + "</code>");
  return "<div class=\"card\"><h3>Command and machine</h3>\n<dl class=\"facts\">\n" + rows +
         "</dl></div>\n";
}

std::string view_table(const RunReport& report) {
  if (report.views.empty()) return "";
  const auto number = [](const std::optional<double>& value) {
    return fmt::format("<td class=\"number\">{}</td>", value ? fmt::format("{:.2f}", *value) : "–");
  };
  std::string rows;
  for (const ScoredView& view : report.views)
    rows += fmt::format("<tr><td>{}</td><td>{}</td>{}{}{}{}</tr>\n", html_text(view.name),
                        html_text(view.camera), number(view.time), number(view.psnr),
                        number(view.psnr_dynamic), number(view.psnr_static));
  return fmt::format(
      "<h2>All views</h2>\n<details><summary>{} {} with their scores</summary>\n"
      "<div class=\"wide\"><table>\n<thead><tr><th class=\"sort\">view</th>"
      "<th class=\"sort\">camera</th><th class=\"sort number\">time</th>"
      "<th class=\"sort number\">PSNR [dB]</th><th class=\"sort number\">moving pixels [dB]</th>"
      "<th class=\"sort number\">static pixels [dB]</th></tr></thead>\n<tbody>\n{}</tbody>\n"
      "</table></div></details>\n",
      report.views.size(), views_words(report.split), rows);
}

std::vector<ChartPoint> in_megabytes(std::vector<ChartPoint> points) {
  for (ChartPoint& point : points) point.y /= 1e6;
  return points;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> run_charts(const RunReport& report) {
  const RunCurves& curves = report.curves;
  const std::string first = preset_colour(report.preset);
  const std::string second = first == "#D55E00" ? "#0072B2" : "#D55E00";
  const std::vector<std::pair<std::string, Chart>> all = {
      {"psnr",
       {"PSNR",
        "step",
        "PSNR [dB]",
        {{"test views", first, curves.psnr_test},
         {"validation views", second, curves.psnr_validation}}}},
      {"loss", {"Loss", "step", "loss", {{"training loss", first, curves.loss}}, true}},
      {"gaussians",
       {"Gaussians",
        "step",
        "number of Gaussians",
        {{"static", first, curves.num_static}, {"dynamic", second, curves.num_dynamic}},
        true}},
      {"memory",
       {"Memory",
        "step",
        "peak memory [MB]",
        {{"peak of the device", first, in_megabytes(curves.bytes)}},
        true}}};
  std::vector<std::pair<std::string, std::string>> charts;
  for (const auto& [name, chart] : all)
    if (std::string svg = svg_chart(chart); !svg.empty()) charts.emplace_back(name, std::move(svg));
  return charts;
}

std::string run_page(const RunPage& page) {
  const RunReport& report = page.report;
  const std::string body =
      head(page) + scores(page) + warnings(report) + camera_section(report.cameras) +
      telling(page) + strips(page.images) + charts(report) + decisions(report) +
      "<h2>Run</h2>\n<div class=\"pair\">\n" + stages(report) + files(page) + machine(report) +
      "</div>\n" + view_table(report) +
      fmt::format("<footer>Made by Tessera {}.</footer>\n", html_text(report.version));
  return report_frame("Tessera: " + page.title, body);
}

}  // namespace tessera
