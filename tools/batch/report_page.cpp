// What: the sections of a batch's report as HTML; every name is escaped.
// Not: the frame around them (report_template.h).
#include "tools/batch/report_page.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "kernels/base/byte_units.h"
#include "tools/batch/report_template.h"
#include "tools/player/page_words.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string cell(const std::string& html) {
  return fmt::format("<td>{}</td>", html);
}

/// "28.31", and under it least and most where there are several seeds; a dash where not measured.
std::string number_cell(const json& metrics, const char* metric, const char* format,
                        double unit = 1) {
  const json spread = metrics.value(metric, json());
  if (!spread.is_object()) return "<td class=\"number faint\">-</td>";
  const auto text = [&](const char* part) {
    return fmt::format(fmt::runtime(format), spread[part].get<double>() / unit);
  };
  std::string range;
  if (spread["count"] > 1)
    range = fmt::format("<br><span class=\"faint\">{} to {}</span>", text("least"), text("most"));
  return fmt::format("<td class=\"number\">{}{}</td>", text("median"), range);
}

std::string link(const std::string& below_out, const std::string& text) {
  return fmt::format("<a href=\"{}\">{}</a>", html_address(fs::path("..") / below_out),
                     html_text(text));
}

/// Players of the seeds of one point.
std::string players(const json& report, const json& scene, const json& label) {
  std::string links;
  for (const json& run : report["runs"]) {
    if (run["scene"] != scene || run["preset"] != label || run["player"] == "") continue;
    links += links.empty() ? "" : " ";
    links += link(run["player"], fmt::format("seed {}", run["seed"].dump()));
  }
  return links.empty() ? "<span class=\"faint\">-</span>" : links;
}

std::string runs_text(const json& report, const json& scene, const json& label) {
  int done = 0, failed = 0, all = 0;
  for (const json& run : report["runs"]) {
    if (run["scene"] != scene || run["preset"] != label) continue;
    ++all;
    done += run["state"] == "done";
    failed += run["state"] == "failed";
  }
  std::string text = fmt::format("{} of {}", done, all);
  if (failed > 0) text += fmt::format("<br><span class=\"bad\">{} failed</span>", failed);
  return text;
}

bool scored_on_training(const json& scene) {
  return scene.value("split", "") == "train";
}

/// PSNR; that of training views says so.
std::string psnr_cell(const json& scene, const json& metrics) {
  std::string html = number_cell(metrics, "psnr", "{:.2f}");
  if (scored_on_training(scene) && metrics.contains("psnr"))
    html.insert(html.rfind("</td>"), "<br><span class=\"faint\">training views</span>");
  return html;
}

std::string results(const json& report) {
  std::string rows;
  for (const json& scene : report["scenes"])
    for (const json& point : scene["points"]) {
      const json& metrics = point["metrics"];
      rows += "<tr>";
      rows += cell(html_text(std::string(scene["scene"]))) +
              cell(html_text(std::string(point["label"]))) +
              cell(runs_text(report, scene["scene"], point["label"])) + psnr_cell(scene, metrics) +
              number_cell(metrics, "ssim", "{:.4f}") + number_cell(metrics, "seconds", "{:.1f}") +
              number_cell(metrics, "num_gaussians", "{:.0f}") +
              number_cell(metrics, "bytes", "{:.2f}", kMiB) +
              number_cell(metrics, "shipped_bytes", "{:.2f}", kMiB) +
              cell(players(report, scene["scene"], point["label"])) + "</tr>\n";
    }
  return "<h2>Results</h2>\n<p class=\"faint\">On the held-out views (on the training views where "
         "none are held out). Median over seeds, least and most below.</p>\n<div class=\"wide\">"
         "<table>\n<tr><th>scene</th><th>preset</th><th>runs</th><th>PSNR [dB]</th><th>SSIM</th>"
         "<th>training [s]</th><th>Gaussians</th><th>model [MiB]</th><th>4D file [MiB]</th>"
         "<th>player</th></tr>\n" +
         rows + "</table></div>\n";
}

std::string charts(const ReportImages& images) {
  if (images.charts.empty() && images.chart_note.empty()) return "";
  std::string html = "<h2>Speed and accuracy</h2>\n";
  if (!images.chart_note.empty())
    html += fmt::format("<p class=\"faint\">{}</p>\n", html_text(images.chart_note));
  html += "<div class=\"charts\">\n";
  for (const auto& [scene, svg] : images.charts)
    html += fmt::format("<img class=\"chart\" alt=\"chart of {}\" src=\"{}\">\n", html_text(scene),
                        data_address("image/svg+xml", svg));
  return html + "</div>\n";
}

std::string image_cell(const std::string& png, const std::string& words) {
  return cell(fmt::format("<img class=\"view\" alt=\"{0}\" src=\"{1}\">{0}", html_text(words),
                          data_address("image/png", png)));
}

/// Of the scenes with held-out views, or of those without.
std::string views(const ReportImages& images, bool training) {
  std::string html;
  for (const auto& [scene, frames] : images.views) {
    if (frames.empty() || frames.front().training != training) continue;
    html += fmt::format("<h3>{}</h3>\n<div class=\"wide\"><table>\n", html_text(scene));
    for (const ComparedView& view : frames) {
      html += "<tr>";
      html += image_cell(view.truth, fmt::format("truth: {}", view.frame));
      for (const ComparedView::Render& render : view.renders)
        html += image_cell(render.png, fmt::format("{}: {:.2f} dB", render.preset, render.psnr));
      html += "</tr>\n";
    }
    html += "</table></div>\n";
  }
  const char* const heading = training ? "Training views" : "Held-out views";
  return html.empty() ? "" : fmt::format("<h2>{}</h2>\n", heading) + html;
}

std::string image_notes(const ReportImages& images) {
  std::string html;
  for (const std::string& note : images.notes)
    html += fmt::format("<p class=\"faint\">{}</p>\n", html_text(note));
  return html;
}

std::string failures(const json& report) {
  if (report["failures"].empty()) return "";
  std::string items;
  for (const json& failure : report["failures"])
    items += fmt::format("<li>{}</li>\n", html_text(std::string(failure["line"])));
  return "<h2 class=\"bad\">Failures</h2>\n<ul>\n" + items + "</ul>\n";
}

std::string list_of(const json& words) {
  std::string text;
  for (const json& word : words)
    text += (text.empty() ? "" : "<br>") +
            html_text(word.is_string() ? word.get<std::string>() : word.dump());
  return text.empty() ? "<span class=\"faint\">none yet</span>" : text;
}

std::string row(const std::string& heading, const std::string& html) {
  return fmt::format("<tr><th>{}</th>{}</tr>\n", html_text(heading), cell(html));
}

std::string code(const std::string& text) {
  return fmt::format("<code>{}</code>", html_text(text));
}

/// Of a file that people may have edited. Not operator[], which reads beyond the end of a constant
/// object where a key is missing.
std::string text_of(const json& object, const char* key, const char* otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  return found->is_string() ? found->get<std::string>() : found->dump();
}

/// What was asked for, so that it can be asked for again.
std::string settings(const json& report) {
  std::string rows =
      row("versions", list_of(report["versions"])) + row("devices", list_of(report["devices"]));
  for (const json& variant : report["variants"])
    rows += row("preset " + text_of(variant, "name", ""),
                code(text_of(variant, "preset", "") + " " + text_of(variant, "options", "{}")));
  for (const json& capture : report["captures"]) rows += row("capture", code(capture.dump()));
  std::string notes;
  for (const json& note : report["notes"])
    notes += fmt::format("<p class=\"faint\">{}</p>\n", html_text(std::string(note)));
  return "<h2>Versions, devices, options</h2>\n<div class=\"wide\"><table>\n" + rows +
         "</table></div>\n<p class=\"faint\">The numbers: <a href=\"report.csv\">report.csv</a>, "
         "<a href=\"report.json\">report.json</a>.</p>\n" +
         notes;
}

void fill(std::string& page, const std::string& place, const std::string& html) {
  for (size_t position = page.find(place); position != std::string::npos;
       position = page.find(place, position + html.size()))
    page.replace(position, place.size(), html);
}

}  // namespace

std::string report_page(const json& report, const ReportImages& images) {
  const bool nothing = report["counts"]["done"] == 0 && report["counts"]["failed"] == 0;
  const std::string body =
      (nothing ? "<p><strong>Nothing is done yet.</strong> Run the batch, then make this report "
                 "again.</p>\n"
               : failures(report)) +
      (report["runs"].empty() ? "" : results(report)) + charts(images) + views(images, false) +
      views(images, true) + image_notes(images) + settings(report);
  std::string page = kReportTemplate;
  fill(page, "{{title}}", html_text(std::string(report["title"])));
  fill(page, "{{summary}}", html_text(std::string(report["summary"])));
  fill(page, "{{body}}", body);
  return page;
}

}  // namespace tessera
