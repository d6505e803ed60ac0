// Gathers the data of a report from the records of a run.
#include "tools/report/run_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/camera_table_text.h"
#include "tools/report/camera_section.h"
#include "tools/report/log_events.h"

namespace tessera {
namespace {

using nlohmann::json;

/// The words of a command as they can be typed again.
std::string command_text(const json& words) {
  std::string text;
  if (!words.is_array()) return text;
  for (const json& word : words) {
    if (!word.is_string()) continue;
    std::string quoted = word.get<std::string>();
    if (text.empty()) quoted = quoted.substr(quoted.rfind('/') + 1);  // the program
    if (quoted.empty() ||
        quoted.find_first_of(" \t\n'\"\\$&|;<>()*?[]{}~`!#") != std::string::npos) {
      for (size_t i = quoted.find('\''); i != std::string::npos; i = quoted.find('\'', i + 4))
        quoted.replace(i, 1, "'\\''");
      quoted = fmt::format("'{}'", quoted);
    }
    if (!text.empty()) text += ' ';
    text += quoted;
  }
  return text;
}

void read_starts(const std::vector<json>& events, RunReport& report) {
  for (const json& event : events) {
    if (text_at(event, "event") != "start") continue;
    if (report.started.empty()) report.started = text_at(event, "time");
    if (report.command.empty()) report.command = command_text(field_at(event, "command"));
    if (const std::string host = text_at(event, "host"); !host.empty()) report.host = host;
    if (const std::string cpu = text_at(event, "cpu"); !cpu.empty()) report.cpu = cpu;
  }
}

void add_warning(const std::string& stage, const json& text, RunReport& report) {
  if (!text.is_string()) return;
  const auto& words = text.get_ref<const std::string&>();
  const auto is_same = [&](const RunWarning& known) { return known.text == words; };
  if (std::none_of(report.warnings.begin(), report.warnings.end(), is_same))
    report.warnings.push_back({stage, words});
}

void read_warnings(const RunRecords& records, const std::vector<json>& events, RunReport& report) {
  const json& of_ingest =
      field_at(field_at(field_at(records.stages, "ingest"), "result"), "warnings");
  if (of_ingest.is_array())
    for (const json& text : of_ingest) add_warning("ingest", text, report);
  for (const json& event : events)
    if (text_at(event, "event") == "warning") add_warning("train", field_at(event, "text"), report);
}

/// Those of the ledger; of a training alone the parts of its time.
void read_stages(const RunRecords& records, const std::vector<json>& events, RunReport& report) {
  for (const char* stage : {"ingest", "train", "evaluate", "export", "player"})
    if (const auto seconds = number_at(field_at(records.stages, stage), "seconds"))
      report.stages.push_back({stage, *seconds});
  if (!report.stages.empty() || events.empty()) return;
  const json& parts = field_at(events.back(), "wall_seconds");
  for (const auto& [part, value] : parts.items())
    if (value.is_number()) report.stages.push_back({part, value.get<double>()});
}

void read_scores(const json& metrics, RunReport& report) {
  const auto add = [&](const json& object, const char* key, const char* name, const char* unit,
                       int digits) {
    if (const auto value = number_at(object, key))
      report.scores.push_back({name, fmt::format("{:.{}f}{}", *value, digits, unit)});
  };
  add(metrics, "psnr", "PSNR", " dB", 2);
  add(metrics, "psnr_dynamic", "PSNR of moving pixels", " dB", 2);
  add(metrics, "psnr_static", "PSNR of static pixels", " dB", 2);
  add(metrics, "psnr_fit", "PSNR after camera gains", " dB", 2);
  add(metrics, "ssim", "SSIM", "", 4);
  add(metrics, "lpips", "LPIPS", "", 4);
  const json& timesteps = field_at(metrics, "timesteps");
  const json& worst = field_at(metrics, "worst_timestep");
  if (timesteps.is_array() && timesteps.size() > 1)
    if (const auto psnr = number_at(worst, "psnr"))
      report.scores.push_back(
          {fmt::format("Lowest timestep (frame {})", count_at(worst, "frame_number")),
           fmt::format("{:.2f} dB", *psnr)});
  const json& objects = field_at(metrics, "objects");
  if (!objects.is_array()) return;
  for (const json& object : objects)
    if (const auto psnr = number_at(object, "psnr"))
      report.scores.push_back({text_at(object, "name"), fmt::format("{:.2f} dB", *psnr)});
}

void read_views(const json& metrics, RunReport& report) {
  report.split = text_at(metrics, "split");
  const json& views = field_at(metrics, "per_view");
  if (!views.is_array()) return;
  for (const json& view : views)
    if (const auto psnr = number_at(view, "psnr"))
      report.views.push_back({text_at(view, "name"), text_at(view, "camera"),
                              number_at(view, "time").value_or(0), *psnr,
                              number_at(view, "psnr_dynamic"), number_at(view, "psnr_static")});
}

json curve_json(const std::vector<ChartPoint>& curve) {
  json points = json::array();
  for (const ChartPoint& point : curve) points.push_back({point.x, point.y});
  return points;
}

json or_null(const std::optional<double>& value) {
  return value ? json(*value) : json();
}

}  // namespace

RunReport run_report(const RunRecords& records) {
  const std::vector<json> events = log_events(records.log);
  RunReport report;
  report.version = text_at(records.config, "tessera");
  report.preset = text_at(records.config, "preset");
  report.device = text_at(records.config, "device");
  read_starts(events, report);
  read_warnings(records, events, report);
  report.cameras =
      camera_rows(field_at(field_at(field_at(records.stages, "ingest"), "result"), "camera_table"));
  read_stages(records, events, report);
  read_scores(records.metrics, report);
  read_views(records.metrics, report);
  report.curves = run_curves(events);
  report.decisions = run_decisions(events);
  if (!report.curves.loss.empty()) report.steps = int64_t(report.curves.loss.back().x);
  const auto last = [](const std::vector<ChartPoint>& curve) {
    return curve.empty() ? 0 : int64_t(curve.back().y);
  };
  report.num_static = last(report.curves.num_static);
  report.num_dynamic = last(report.curves.num_dynamic);
  // what is shipped may be smaller than what was trained
  const json& end = events.empty() ? records.metrics : events.back();
  for (const json* source : {&end, &records.metrics})
    if (number_at(*source, "num_static") && number_at(*source, "num_dynamic")) {
      report.num_static = count_at(*source, "num_static");
      report.num_dynamic = count_at(*source, "num_dynamic");
    }
  return report;
}

json to_json(const RunReport& report) {
  json stages = json::array(), views = json::array(), decisions = json::array(),
       warnings = json::array(), scores = json::object();
  for (const StageTime& stage : report.stages)
    stages.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  for (const RunScore& score : report.scores) scores[score.name] = score.value;
  for (const ScoredView& view : report.views)
    views.push_back({{"name", view.name},
                     {"camera", view.camera},
                     {"time", view.time},
                     {"psnr", view.psnr},
                     {"psnr_dynamic", or_null(view.psnr_dynamic)},
                     {"psnr_static", or_null(view.psnr_static)}});
  for (const RunDecision& decision : report.decisions)
    decisions.push_back({{"step", decision.step}, {"text", decision.text}});
  for (const RunWarning& warning : report.warnings)
    warnings.push_back({{"stage", warning.stage}, {"text", warning.text}});
  const RunCurves& curves = report.curves;
  return {{"version", report.version},
          {"command", report.command},
          {"started", report.started},
          {"host", report.host},
          {"cpu", report.cpu},
          {"device", report.device},
          {"preset", report.preset},
          {"steps", report.steps},
          {"num_static", report.num_static},
          {"num_dynamic", report.num_dynamic},
          {"stages", stages},
          {"curves",
           {{"psnr_test", curve_json(curves.psnr_test)},
            {"psnr_validation", curve_json(curves.psnr_validation)},
            {"loss", curve_json(curves.loss)},
            {"num_static", curve_json(curves.num_static)},
            {"num_dynamic", curve_json(curves.num_dynamic)},
            {"bytes", curve_json(curves.bytes)}}},
          {"scores", scores},
          {"split", report.split},
          {"views", views},
          {"decisions", decisions},
          {"warnings", warnings},
          {"camera_table", camera_table_json(report.cameras)}};
}

}  // namespace tessera
