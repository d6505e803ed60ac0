// Gathers the data of a report from the records of a run.
#include "tools/report/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tools/report/log_events.h"
#include "tools/report/windows_report.h"
#include "tools/session/held_out_scores.h"

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

/// Of the starts of a training the first one's time, command and initial points, and the last one's
/// machine.
json starts_of(const std::vector<json>& events) {
  json found = {
      {"started", ""}, {"command", ""}, {"initial_points", ""}, {"host", ""}, {"cpu", ""}};
  for (const json& event : events) {
    if (text_at(event, "event") != "start") continue;
    if (found["started"] == "") {
      found["started"] = text_at(event, "time");
      found["initial_points"] = text_at(event, "initialisation");
    }
    if (found["command"] == "") found["command"] = command_text(field_at(event, "command"));
    for (const char* key : {"host", "cpu"})
      if (const std::string text = text_at(event, key); !text.empty()) found[key] = text;
  }
  return found;
}

/// The stages have the seconds of the last session alone.
bool was_resumed(const RunRecords& records, const std::vector<json>& events) {
  const json& trained = field_at(field_at(records.stages, "train"), "result");
  return field_at(trained, "continued") == true ||
         std::any_of(events.begin(), events.end(), [](const json& event) {
           return text_at(event, "event") == "start" && count_at(event, "iteration") > 0;
         });
}

void add_warning(const char* stage, const json& text, json& warnings) {
  if (!text.is_string()) return;
  const auto is_same = [&](const json& known) { return known["text"] == text; };
  if (std::none_of(warnings.begin(), warnings.end(), is_same))
    warnings.push_back({{"stage", stage}, {"text", text}});
}

/// Each once.
json warnings_of(const json& ingest, const std::vector<json>& events) {
  json warnings = json::array();
  if (const json& texts = field_at(ingest, "warnings"); texts.is_array())
    for (const json& text : texts) add_warning("ingest", text, warnings);
  for (const json& event : events)
    if (text_at(event, "event") == "warning")
      add_warning("train", field_at(event, "text"), warnings);
  return warnings;
}

/// Those of the ledger; of a training alone the parts of its time.
json stages_of(const json& ledger, const json& end) {
  json stages = json::array();
  for (const char* stage : {"ingest", "train", "evaluate", "export", "player"})
    if (const auto seconds = number_at(field_at(ledger, stage), "seconds"))
      stages.push_back({{"name", stage}, {"seconds", *seconds}});
  if (!stages.empty()) return stages;
  for (const auto& [part, value] : field_at(end, "wall_seconds").items())
    if (value.is_number()) stages.push_back({{"name", part}, {"seconds", value}});
  return stages;
}

/// As they were asked for. Names with spaces are those of hashes and of what was found.
json ingest_options_of(const json& inputs) {
  json options = json::object();
  for (const auto& [name, value] : inputs.items())
    if (name.find(' ') == std::string::npos) options[name] = value;
  return options;
}

json scores_of(const json& metrics) {
  json scores;
  for (const char* key : {"psnr", "psnr_dynamic", "psnr_static", "psnr_fit", "ssim", "lpips"})
    scores[key] = or_null(number_at(metrics, key));
  return scores;
}

/// The lowest timestep, where there are several.
json worst_of(const json& metrics) {
  const json& timesteps = field_at(metrics, "timesteps");
  const json& worst = field_at(metrics, "worst_timestep");
  const auto psnr = number_at(worst, "psnr");
  if (!psnr || !timesteps.is_array() || timesteps.size() < 2) return nullptr;
  return {{"frame_number", count_at(worst, "frame_number")}, {"psnr", *psnr}};
}

json objects_of(const json& metrics) {
  json objects = json::array();
  if (const json& scored = field_at(metrics, "objects"); scored.is_array())
    for (const json& object : scored)
      if (const auto psnr = number_at(object, "psnr"))
        objects.push_back({{"name", text_at(object, "name")}, {"psnr", *psnr}});
  return objects;
}

json views_of(const json& metrics) {
  json views = json::array();
  for (const ScoredView& view : scored_views(metrics))
    views.push_back({{"name", view.name},
                     {"camera", view.camera},
                     {"time", view.time},
                     {"psnr", view.psnr},
                     {"psnr_dynamic", or_null(view.psnr_dynamic)},
                     {"psnr_static", or_null(view.psnr_static)}});
  return views;
}

/// Of the ingest, with what the training has learnt of clocks and readouts.
json cameras_of(const json& ingest, const json& trained) {
  const json& table = field_at(ingest, "camera_table");
  json cameras = table.is_array() ? table : json::array();
  for (json& camera : cameras) {
    const std::string name = text_at(camera, "name");
    camera["clock_learnt_s"] = or_null(number_at(field_at(trained, "clocks"), name.c_str()));
    camera["readout_learnt_s"] = or_null(number_at(field_at(trained, "readouts"), name.c_str()));
  }
  return cameras;
}

/// Gaussians: of the model that was scored, which may be smaller than what was trained.
json counts_of(const RunRecords& records, const RunCurves& curves, const json& end) {
  const auto last = [](const std::vector<CurvePoint>& curve) {
    return curve.empty() ? 0 : int64_t(curve.back().value);
  };
  json size = {{"static", last(curves.num_static)}, {"dynamic", last(curves.num_dynamic)}};
  for (const json* source : {&end, &records.metrics})
    if (number_at(*source, "num_static") && number_at(*source, "num_dynamic")) {
      size["static"] = count_at(*source, "num_static");
      size["dynamic"] = count_at(*source, "num_dynamic");
    }
  size["peak_bytes"] = curves.bytes.empty() ? json() : json(int64_t(curves.bytes.back().value));
  return size;
}

/// Where the training has left the scores of its last model to `evaluate`.
void add_last_score(const json& metrics, const json& end, RunCurves& curves) {
  const std::optional<double> psnr = number_at(metrics, "psnr"),
                              step = number_at(end, "iterations");
  const bool is_last = text_at(metrics, "split") != "train" && curves.psnr_validation.empty();
  if (!psnr || !step || !is_last) return;
  if (curves.psnr_test.empty() || double(curves.psnr_test.back().step) < *step)
    curves.psnr_test.push_back({int64_t(*step), number_at(end, "seconds").value_or(0), *psnr});
}

/// Of a clip in windows those of all.
std::vector<json> all_events(const RunRecords& records) {
  if (records.windows.empty()) return log_events(records.log);
  std::vector<json> all;
  for (const WindowRecords& window : records.windows)
    for (json& event : log_events(window.log)) all.push_back(std::move(event));
  return all;
}

}  // namespace

std::vector<ScoredView> scored_views(const json& metrics) {
  std::vector<ScoredView> found;
  const json& views = field_at(metrics, "per_view");
  if (!views.is_array()) return found;
  for (const json& view : views)
    if (const auto psnr = number_at(view, "psnr"))
      found.push_back({text_at(view, "name"), text_at(view, "camera"),
                       number_at(view, "time").value_or(0), *psnr, number_at(view, "psnr_dynamic"),
                       number_at(view, "psnr_static")});
  return found;
}

json run_report(const RunRecords& records) {
  const bool in_windows = !records.windows.empty();
  const std::vector<json> events = log_events(records.log), all = all_events(records);
  const bool is_done = !in_windows && !events.empty() && text_at(events.back(), "event") == "end";
  const json& end = is_done ? events.back() : records.trained;
  const json& ingest = field_at(field_at(records.stages, "ingest"), "result");
  RunCurves curves;
  if (!in_windows) {
    curves = run_curves(events);
    add_last_score(records.metrics, end, curves);
  }
  json run = starts_of(events);
  run["preset"] = text_at(records.config, "preset");
  run["seed"] = field_at(records.config, "seed");
  run["version"] = text_at(records.config, "tessera");
  run["commit"] = text_at(records.config, "commit");
  run["device"] = text_at(records.config, "device");
  run["state"] = is_done ? "done" : "unfinished";
  run["split"] = text_at(records.metrics, "split");
  run["steps"] = curves.loss.empty() ? count_at(end, "iterations") : curves.loss.back().step;
  const json& options = field_at(records.config, "options");
  run["options"] = options.is_object() ? options : json::object();
  run["ingest_options"] = ingest_options_of(field_at(field_at(records.stages, "ingest"), "inputs"));
  run["scores"] = scores_of(records.metrics);
  run["verdict"] = run["split"] == "train" ? "" : verdict(run["scores"]);
  run["worst"] = worst_of(records.metrics);
  run["objects"] = objects_of(records.metrics);
  run["size"] = counts_of(records, curves, end);
  run["stages"] = stages_of(records.stages, end);
  double command = 0;
  for (const json& stage : run["stages"]) command += stage["seconds"].get<double>();
  run["seconds"] = {{"command", command > 0 && !was_resumed(records, all) ? json(command) : json()},
                    {"training", or_null(number_at(end, "seconds"))}};
  run["curves"] = to_json(curves);
  run["views"] = views_of(records.metrics);
  run["cameras"] = cameras_of(ingest, end);
  run["decisions"] = in_windows ? json::array() : run_decisions(events);
  run["warnings"] = warnings_of(ingest, all);
  if (in_windows) add_windows(records, run);
  return run;
}

}  // namespace tessera
