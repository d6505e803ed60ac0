// Joins the data of the batch with the images of its runs' reports, and writes the files.
#include "tools/batch/write_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tools/batch/batch_report.h"
#include "tools/batch/points.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/report/log_events.h"
#include "tools/report/report_page.h"
#include "tools/report/write_run_report.h"
#include "tools/session/device_choice.h"
#include "tools/session/run_folder.h"
#include "tools/session/version.h"
#include "tools/web/page_words.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr size_t kMostImageBytes = 16 << 20;  // within the page; above, it names their files
constexpr const char* kImages[] = {"truth", "result", "error"};

bool is_older(const fs::path& file, const fs::path& than) {
  std::error_code absent;
  const auto time = fs::last_write_time(than, absent);
  return !absent && fs::last_write_time(file) < time;
}

/// The entry of a run in its own report, which is written where there is none of this model.
json own_report(const fs::path& folder, const std::string& backend) {
  const RunFolder run{folder};
  const fs::path file = folder / "report" / "report.json";
  std::vector<std::string> ignored;
  json report = read_object(file, ignored);
  const bool current = count_at(report, "schema") == kReportSchema &&
                       text_at(report, "version") == kVersionText && report.contains("runs") &&
                       !is_older(file, run.model()) && !is_older(file, run.metrics());
  if (!current) report = write_run_report({{folder}, {}, [&] { return make_backend(backend); }});
  return report["runs"][0];
}

/// `path` of a file of a run's report, from the report of the batch.
fs::path from_batch(const json& run, const std::string& path) {
  return (fs::path("..") / run["folder"].get<std::string>() / "report" / path).lexically_normal();
}

/// Gives a run the views that have images in its own report, and a link to that.
void take_views(const json& own, json& run) {
  run["image_note"] = own.value("image_note", json());
  for (const json& view : own["views"]) {
    if (!view.contains("truth") || view["truth"].is_null()) continue;
    run["views"].push_back(view);
    for (const char* image : kImages)
      if (run["views"].back()[image].is_string())
        run["views"].back()[image] = from_batch(run, view[image]).generic_string();
  }
  run["files"].insert(run["files"].begin(),
                      json{{"name", "Report"},
                           {"path", from_batch(run, "index.html").generic_string()},
                           {"bytes", nullptr}});
}

/// Of each scene and variant the first seed that has a score has images.
void add_images(const ReportRequest& request, json& runs) {
  std::set<std::pair<std::string, std::string>> shown;
  ProgressBar bar("report");
  int64_t done = 0;
  for (json& run : runs) {
    stop_if_interrupted();
    bar.update(++done, int64_t(runs.size()), "runs");
    run["views"] = json::array();  // of a batch, those with images alone
    if (!request.images || run["scores"]["psnr"].is_null()) continue;
    if (!shown.emplace(run["scene"], run["variant"]).second) continue;
    try {
      take_views(own_report(request.out / run["folder"].get<std::string>(), request.backend), run);
    } catch (const InputError& error) {
      run["image_note"] = error.what();
    }
  }
}

/// The report with its images in it, where they are small together.
json with_images_inside(json report, const fs::path& folder) {
  size_t bytes = 0;
  json inside = report;
  for (json& run : inside["runs"])
    for (json& view : run["views"])
      for (const char* image : kImages) {
        if (!view[image].is_string()) continue;
        const fs::path file = folder / view[image].get<std::string>();
        const std::string content = fs::exists(file) ? read_text_file(file) : "";
        bytes += content.size();
        if (bytes > kMostImageBytes) return report;
        view[image] =
            data_address(file.extension() == ".png" ? "image/png" : "image/jpeg", content);
      }
  return inside;
}

}  // namespace

json write_report(const ReportRequest& request) {
  json report = batch_report(read_batch(request.out));
  report["schema"] = kReportSchema;
  report["version"] = kVersionText;
  report["made"] = utc_time();
  add_images(request, report["runs"]);
  const fs::path folder = request.out / "report";
  make_folder(folder);
  std::vector<std::pair<fs::path, std::string>> files = {
      {folder / "report.csv", csv_of(report["batch"]["scenes"])},
      {folder / "report.json", report_text(report)}};
  if (carries_pages())
    files.emplace_back(folder / "index.html",
                       filled_report_page(with_images_inside(report, folder)));
  write_together(files);
  return report;
}

}  // namespace tessera
