// Reads the lines of a log and makes curves of them.
#include "tools/report/log_events.h"

#include <cmath>
#include <sstream>

namespace tessera {

using nlohmann::json;

const json& field_at(const json& object, const char* key) {
  static const json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(key);
  return found == object.end() ? nothing : *found;
}

std::optional<double> number_at(const json& object, const char* key) {
  const json& field = field_at(object, key);
  if (!field.is_number() || !std::isfinite(field.get<double>())) return std::nullopt;
  return field.get<double>();
}

std::string text_at(const json& object, const char* key) {
  const json& field = field_at(object, key);
  return field.is_string() ? field.get<std::string>() : "";
}

int64_t count_at(const json& object, const char* key) {
  const json& field = field_at(object, key);
  return field.is_number_integer() ? field.get<int64_t>() : 0;
}

std::vector<json> log_events(const std::string& log) {
  std::vector<json> events;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    json event = json::parse(line, nullptr, false);
    const std::string name = text_at(event, "event");
    if (name.empty()) continue;
    if (name == "start") {
      const int64_t first = count_at(event, "iteration");
      std::erase_if(events, [&](const json& earlier) {
        return text_at(earlier, "event") != "warning" &&
               (count_at(earlier, "iteration") > first || text_at(earlier, "event") == "end");
      });
    }
    events.push_back(std::move(event));
  }
  return events;
}

RunCurves run_curves(const std::vector<json>& events) {
  RunCurves curves;
  double seconds = 0;
  int64_t known_to = 0;  // steps whose seconds are in the sum
  for (const json& event : events) {
    const std::string name = text_at(event, "event");
    const int64_t step = count_at(event, "iteration");
    const auto add = [&](std::vector<CurvePoint>& curve, const json& object, const char* key) {
      if (const auto value = number_at(object, key)) curve.push_back({step, seconds, *value});
    };
    if (name == "steps") {
      seconds += number_at(event, "seconds_per_step").value_or(0) * double(step - known_to);
      known_to = step;
      add(curves.loss, event, "loss");
      add(curves.num_static, event, "num_static");
      add(curves.num_dynamic, event, "num_dynamic");
      add(curves.bytes, event, "peak_device_bytes");
    } else if (name == "decision") {
      seconds += number_at(event, "decision_seconds").value_or(0);
    } else if (name == "validation") {
      add(curves.psnr_validation, event, "psnr");
    } else if (name == "evaluation") {
      const json& splits = field_at(event, "splits");
      add(curves.psnr_test, field_at(splits, splits.contains("test") ? "test" : "val"), "psnr");
    }
  }
  return curves;
}

json to_json(const std::vector<CurvePoint>& curve) {
  json made = {{"step", json::array()}, {"seconds", json::array()}, {"value", json::array()}};
  for (const CurvePoint& point : curve) {
    made["step"].push_back(point.step);
    made["seconds"].push_back(point.seconds);
    made["value"].push_back(point.value);
  }
  return made;
}

json to_json(const RunCurves& curves) {
  return {{"psnr_test", to_json(curves.psnr_test)},
          {"psnr_validation", to_json(curves.psnr_validation)},
          {"loss", to_json(curves.loss)},
          {"static", to_json(curves.num_static)},
          {"dynamic", to_json(curves.num_dynamic)},
          {"memory", to_json(curves.bytes)}};
}

json or_null(const std::optional<double>& value) {
  return value ? json(*value) : json();
}

}  // namespace tessera
