// The sections of the page of a batch.
#include "tools/batch/batch_page.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/batch/batch_tables.h"
#include "tools/report/axis.h"
#include "tools/report/report_pieces.h"
#include "tools/web/page_words.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr size_t kManyScenes = 12;  // above, each is folded

/// Of a file that people may have edited. Not operator[], which reads beyond the end of a constant
/// object where a key is missing.
std::string text_of(const json& object, const char* key, const char* otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  return found->is_string() ? found->get<std::string>() : found->dump();
}

std::string soft_line(const std::string& text) {
  return fmt::format("<p class=\"soft\">{}</p>\n", html_text(text));
}

/// The last word of its folder.
std::string name_of(const json& report) {
  const fs::path folder = report["title"].get<std::string>();
  return (folder.has_filename() ? folder : folder.parent_path()).filename().string();
}

std::string head(const json& report) {
  return fmt::format("<h1>{}</h1>\n", html_text(name_of(report))) + soft_line(report["summary"]);
}

std::string failures(const json& report) {
  std::string items;
  for (const json& failure : report["failures"]) {
    const std::string log = text_of(failure, "log", "");
    items += fmt::format("<li>{}", html_text(text_of(failure, "line", "")));
    if (!log.empty())
      items += fmt::format(" (<a href=\"{}\">log</a>)", html_address(fs::path("..") / log));
    items += "</li>\n";
  }
  if (items.empty()) return "";
  return "<h2 class=\"bad\">Failures</h2>\n<div class=\"card warnings\"><ul>\n" + items +
         "</ul></div>\n";
}

std::string overview(const json& report) {
  if (report["scenes"].size() < 2) return "";
  return "<h2>All scenes</h2>\n" +
         soft_line(
             "Medians over the seeds, on the held-out views; the best of a scene is bold. "
             "Below: time of training and size of the model.") +
         scenes_table(report);
}

std::string view_image(const std::string& png, const std::string& words) {
  return fmt::format("<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>\n",
                     html_text(words), data_address("image/png", png));
}

std::string views(const std::string& scene, const BatchImages& images) {
  std::string html;
  for (const auto& [name, frames] : images.views)
    for (const ComparedView& view : frames) {
      if (name != scene) continue;
      html +=
          "<div class=\"strip\" tabindex=\"0\">\n" + view_image(view.truth, "truth: " + view.frame);
      for (const ComparedView::Render& render : view.renders)
        html += view_image(render.png, fmt::format("{}: {:.2f} dB", render.preset, render.psnr));
      html += "</div>\n";
    }
  return html;
}

std::string chart(const std::string& scene, const BatchImages& images) {
  for (const auto& [name, svg] : images.charts)
    if (name == scene) return "<div class=\"chart\">" + svg + "</div>\n";
  return "";
}

std::string scene_section(const json& report, const json& scene, const BatchImages& images) {
  const std::string name = scene["scene"];
  std::string html = scene_table(report, scene);
  html += scene.value("split", "") == "train"
              ? soft_line("Scored on training views, as nothing is held out.")
              : "";
  html = "<div class=\"card\">\n" + html + chart(name, images) + views(name, images) + "</div>\n";
  const std::string heading = html_text(name);
  if (report["scenes"].size() > kManyScenes)
    return fmt::format("<details><summary>{}</summary>\n{}</details>\n", heading, html);
  return fmt::format("<h2>{}</h2>\n{}", heading, html);
}

std::string scenes(const json& report, const BatchImages& images) {
  std::string html;
  for (const json& scene : report["scenes"]) html += scene_section(report, scene, images);
  if (report["scenes"].size() > kManyScenes) html = "<h2>Scene by scene</h2>\n" + html;
  for (const std::string& note : images.notes) html += soft_line(note);
  return html;
}

std::string number_cell(const json& run, const char* key, std::string (*words)(double)) {
  return fmt::format("<td class=\"number\">{}</td>", run.contains(key) ? words(run[key]) : "–");
}

/// Finished runs that the batch does not request any more: their scores, and nothing made of them.
std::string earlier_runs(const json& report) {
  std::string rows;
  for (const json& run : report["earlier_runs"]) {
    const std::string player = text_of(run, "player", "");
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td>",
                        html_text(run["scene"].get<std::string>()),
                        html_text(run["preset"].get<std::string>()), run["seed"].dump());
    rows += number_cell(run, "iterations", [](double v) { return fmt::format("{:.0f}", v); });
    rows += number_cell(run, "psnr", [](double v) { return fmt::format("{:.2f}", v); });
    rows += number_cell(run, "seconds", time_words);
    rows += number_cell(run, "bytes", [](double v) { return size_words(int64_t(v)); });
    rows += player.empty() ? "<td></td>"
                           : fmt::format("<td><a href=\"{}\">player</a></td>",
                                         html_address(fs::path("..") / player));
    rows += "</tr>\n";
  }
  if (rows.empty()) return "";
  return "<h2>Runs of an earlier request</h2>\n" +
         soft_line(
             "They are in the folder, but batch.yaml does not request them any more. No table, "
             "mean or count above includes them.") +
         "<div class=\"card wide\"><table>\n<thead><tr><th>scene</th><th>preset</th>"
         "<th class=\"number\">seed</th><th class=\"number\">steps</th>"
         "<th class=\"number\">PSNR [dB]</th><th class=\"number\">training</th>"
         "<th class=\"number\">model</th><th></th></tr></thead>\n<tbody>\n" +
         rows + "</tbody></table></div>\n";
}

std::string list_of(const json& words) {
  std::string text;
  for (const json& word : words)
    text += (text.empty() ? "" : "<br>") +
            html_text(word.is_string() ? word.get<std::string>() : word.dump());
  return text;
}

std::string code(const std::string& text) {
  return fmt::format("<code>{}</code>", html_text(text));
}

/// The options of the batch, by which it can be repeated.
std::string settings(const json& report) {
  std::string rows = fact_html("folder", code(report["title"])) +
                     fact_html("versions", list_of(report["versions"])) +
                     fact_html("devices", list_of(report["devices"]));
  for (const json& variant : report["variants"])
    rows +=
        fact_html("preset " + text_of(variant, "name", ""),
                  code(text_of(variant, "preset", "") + " " + text_of(variant, "options", "{}")));
  for (const json& capture : report["captures"])
    rows += fact_html("capture " + text_of(capture, "name", ""), code(capture.dump()));
  std::string notes;
  for (const json& note : report["notes"]) notes += soft_line(note);
  return "<h2>Versions, devices, options</h2>\n<div class=\"card\"><dl class=\"facts\">\n" + rows +
         "</dl></div>\n<p class=\"soft\">The numbers: <a href=\"report.csv\">report.csv</a>, "
         "<a href=\"report.json\">report.json</a>.</p>\n" +
         notes;
}

}  // namespace

std::string batch_page(const json& report, const BatchImages& images) {
  const bool nothing = report["counts"]["done"] == 0 && report["counts"]["failed"] == 0;
  const std::string start =
      nothing ? "<p><strong>Nothing is done yet.</strong> Run the batch, then make this report "
                "again.</p>\n"
              : failures(report);
  return report_frame("Tessera: " + name_of(report), head(report) + start + overview(report) +
                                                         scenes(report, images) +
                                                         earlier_runs(report) + settings(report));
}

}  // namespace tessera
