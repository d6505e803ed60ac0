// Scores of a window are the means over the views that are drawn of it.
#include "tools/report/windows_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/report/log_events.h"
#include "tools/report/run_report.h"

namespace tessera {
namespace {

using nlohmann::json;

/// A mean over the values that are there; null where there is none.
class Mean {
 public:
  void add(const std::optional<double>& value) {
    if (!value) return;
    sum_ += *value;
    ++count_;
  }
  json value() const { return count_ > 0 ? json(sum_ / count_) : json(); }

 private:
  double sum_ = 0, count_ = 0;
};

void add_scores(const std::vector<ScoredView>& views, const WindowRecords& window, bool is_last,
                json& to) {
  Mean all, dynamic, fixed;
  for (const ScoredView& view : views) {
    if (view.time < window.begin || (view.time >= window.end && !is_last)) continue;
    all.add(view.psnr);
    dynamic.add(view.psnr_dynamic);
    fixed.add(view.psnr_static);
  }
  to.update(
      {{"psnr", all.value()}, {"psnr_dynamic", dynamic.value()}, {"psnr_static", fixed.value()}});
}

/// What the report of its training has of a window, and the bytes of its model.
json training_of(const WindowRecords& window) {
  RunRecords records;
  records.log = window.log;
  const json run = run_report(records);
  const std::vector<json> events = log_events(window.log);
  const json& size = run["size"];
  return {{"state", run["state"]},
          {"steps", run["steps"]},
          {"static", size["static"]},
          {"dynamic", size["dynamic"]},
          {"seconds", run["seconds"]["training"]},
          {"bytes", run["state"] == "done" ? field_at(events.back(), "bytes") : json()},
          {"peak_bytes", size["peak_bytes"]}};
}

}  // namespace

void add_windows(const RunRecords& records, json& run) {
  const std::vector<ScoredView> views = scored_views(records.metrics);
  json& windows = run["windows"] = json::array();
  WindowRecords of_static;
  of_static.log = records.static_log;
  const json shared = training_of(of_static);
  int64_t steps = count_at(shared, "steps"), dynamic = 0, fixed = 0, bytes = 0, peak = 0;
  double seconds = number_at(shared, "seconds").value_or(0);
  bool is_done = true;
  for (const WindowRecords& window : records.windows) {
    json made = training_of(window);
    made["folder"] = window.folder;
    made["begin"] = window.begin * records.seconds;
    made["end"] = window.end * records.seconds;
    add_scores(views, window, &window == &records.windows.back(), made);
    steps += count_at(made, "steps");
    dynamic += count_at(made, "dynamic");
    fixed = std::max(fixed, count_at(made, "static"));
    seconds += number_at(made, "seconds").value_or(0);
    bytes += count_at(made, "bytes");
    peak = std::max(peak, count_at(made, "peak_bytes"));
    is_done = is_done && made["state"] == "done";
    windows.push_back(std::move(made));
  }
  run["state"] = is_done ? "done" : "unfinished";
  run["steps"] = steps;
  run["size"] = {{"static", fixed}, {"dynamic", dynamic}};
  run["size"]["peak_bytes"] = peak > 0 ? json(peak) : json();
  run["size"]["model_bytes"] = bytes > 0 ? json(bytes) : json();
  run["seconds"]["training"] = is_done ? json(seconds) : json();
  const json& borders = field_at(records.metrics, "borders");
  run["borders"] = borders.is_object() ? borders : json();
}

}  // namespace tessera
