// A file that cannot be read is one that is not there.
#include "tools/report/run_records.h"

#include <tuple>

#include "ingest/files/atomic_file.h"
#include "tools/report/log_events.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string text_if_there(const fs::path& file) {
  return fs::is_regular_file(file) ? read_text_file(file) : "";
}

/// The two numbers of an interval; 0 where there are none.
std::pair<double, double> interval_at(const json& window, const char* key) {
  const json& interval = field_at(window, key);
  if (!interval.is_array() || interval.size() != 2 || !interval[0].is_number() ||
      !interval[1].is_number())
    return {0, 0};
  return {interval[0].get<double>(), interval[1].get<double>()};
}

/// As WindowsFolder::write has them.
std::vector<WindowRecords> windows_of(const fs::path& root, const json& plan) {
  std::vector<WindowRecords> windows;
  const json& listed = field_at(plan, "windows");
  if (!listed.is_array()) return windows;
  for (const json& window : listed) {
    WindowRecords records;
    records.folder = text_at(window, "folder");
    std::tie(records.begin, records.end) = interval_at(window, "drawn");
    records.log = text_if_there(root / records.folder / "log.jsonl");
    windows.push_back(std::move(records));
  }
  return windows;
}

}  // namespace

json json_if_sound(const fs::path& file) {
  json content = json::parse(text_if_there(file), nullptr, false);
  return content.is_discarded() ? json() : content;
}

RunRecords read_records(const fs::path& run) {
  RunRecords records;
  const json plan = json_if_sound(run / "windows.json");
  records.windows = windows_of(run, plan);
  if (!records.windows.empty())
    records.static_log = text_if_there(run / text_at(plan, "static") / "log.jsonl");
  records.seconds = number_at(field_at(plan, "time"), "duration").value_or(0);
  const fs::path first = records.windows.empty() ? run : run / records.windows.front().folder;
  records.config = json_if_sound(first / "config.json");
  records.log = text_if_there(first / "log.jsonl");
  records.metrics = json_if_sound(run / "metrics.json");
  return records;
}

}  // namespace tessera
