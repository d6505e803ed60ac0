// Prepares the captures one after another, keeps the keys of finished scenes in scenes.json, and
// makes the summary.
#include "tools/commands/ingest_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "ingest/files/atomic_file.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "kernels/base/seconds_since.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/output_place.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/terminal.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

/// Everything that the prepared scene depends on.
json report_json(const IngestReport& report) {
  return {{"layout", layout_name(report.layout)},
          {"cameras", report.cameras},
          {"frames", report.frames},
          {"points", report.points},
          {"warnings", report.warnings}};
}

IngestReport report_from_json(const json& stored) {
  IngestReport report;
  for (const LayoutRow& row : layout_rows())
    if (stored.value("layout", "") == row.name) report.layout = row.layout;
  report.cameras = stored.value("cameras", int64_t{0});
  report.frames = stored.value("frames", int64_t{0});
  report.points = stored.value("points", int64_t{0});
  report.warnings = stored.value("warnings", std::vector<std::string>{});
  return report;
}

class Batch {
 public:
  Batch(fs::path out, const IngestOptions& options, bool overwrite)
      : out_(std::move(out)),
        options_(options),
        overwrite_(overwrite),
        ledger_((make_folder(out_), out_ / "scenes.json")) {}

  /// `place`: "2/5".
  BatchScene prepare(const fs::path& capture, const std::string& place) {
    BatchScene scene;
    scene.name = capture.filename().string();
    const auto begin = Clock::now();
    try {
      prepare_or_throw(capture, place, scene);
    } catch (const Interrupted&) {
      throw;
    } catch (const fs::filesystem_error& error) {
      scene.error = fmt::format("{}: cannot be read ({}); check the path and its permissions",
                                capture.string(), error.code().message());
    } catch (const std::exception& error) {
      scene.error = error.what();
    }
    scene.seconds = seconds_since(begin);
    if (!scene.error.empty()) report_error(fmt::format("{}: failed: {}", scene.name, scene.error));
    return scene;
  }

 private:
  void prepare_or_throw(const fs::path& capture, const std::string& place, BatchScene& scene) {
    const fs::path target = out_ / scene.name;
    if (!options_.layout)
      detect_layout(capture, options_.image_layout);  // its error before the stamps of what is none
    json inputs = to_json(options_);
    inputs["files of the capture"] = key_of(file_stamps(capture));
    if (ledger_.done(scene.name, inputs) && is_prepared_scene(target)) {
      say(fmt::format("{} ({}): done before, unchanged", scene.name, place));
      scene.report = report_from_json(ledger_.result(scene.name));
      scene.outcome = BatchOutcome::kUnchanged;
      return;
    }
    check_may_replace(target, "a prepared scene",
                      is_prepared_scene(target) && !ledger_.knows(scene.name), overwrite_);
    ledger_.begin(scene.name, inputs);
    say(fmt::format("{} ({}): begins", scene.name, place));
    scene.report = ingest_with_progress(capture, target, options_,
                                        fmt::format("ingest {} ({})", scene.name, place));
    ledger_.finish(scene.name, report_json(scene.report));
    scene.outcome = BatchOutcome::kDone;
  }

  fs::path out_;
  const IngestOptions& options_;
  const bool overwrite_;
  StageLedger ledger_;
};

const char* outcome_name(BatchOutcome outcome) {
  switch (outcome) {
    case BatchOutcome::kDone:
      return "done";
    case BatchOutcome::kUnchanged:
      return "unchanged";
    case BatchOutcome::kFailed:
      return "failed";
  }
  return "";
}

}  // namespace

int64_t BatchResult::count(BatchOutcome outcome) const {
  return std::count_if(scenes.begin(), scenes.end(),
                       [&](const BatchScene& scene) { return scene.outcome == outcome; });
}

BatchResult ingest_batch(const fs::path& folder, const fs::path& out, const IngestOptions& options,
                         bool overwrite) {
  const std::vector<fs::path> captures = subfolders(folder, out);
  if (std::none_of(captures.begin(), captures.end(), [&](const fs::path& capture) {
        return is_capture(capture, options.image_layout);
      }))
    throw InputError(
        fmt::format("{}: none of its {} subfolders is a capture; name the folder whose subfolders "
                    "are, or one capture",
                    folder.string(), captures.size()));
  for (const fs::path& capture : captures)
    if (is_capture(capture, options.image_layout))
      check_output_apart(out / capture.filename(), capture);
  Batch batch(out, options, overwrite);
  BatchResult result;
  try {
    for (size_t i = 0; i < captures.size(); ++i) {
      stop_if_interrupted();
      result.scenes.push_back(
          batch.prepare(captures[i], fmt::format("{}/{}", i + 1, captures.size())));
    }
  } catch (const Interrupted&) {
    result.interrupted = true;
  }
  return result;
}

std::string batch_table(const BatchResult& result) {
  size_t width = 5;
  for (const BatchScene& scene : result.scenes) width = std::max(width, scene.name.size());
  std::string table = fmt::format("{:{}}  {:10} {:>7} {:>7} {:>9} {:>8}  {}\n", "scene", width,
                                  "layout", "cameras", "frames", "points", "seconds", "outcome");
  for (const BatchScene& scene : result.scenes) {
    if (scene.outcome == BatchOutcome::kFailed) {
      table += fmt::format("{:{}}  {:10} {:>7} {:>7} {:>9} {:>8.1f}  failed: {}\n", scene.name,
                           width, "-", "-", "-", "-", scene.seconds, scene.error);
      continue;
    }
    const IngestReport& report = scene.report;
    const size_t warnings = report.warnings.size();
    table += fmt::format(
        "{:{}}  {:10} {:>7} {:>7} {:>9} {:>8.1f}  {}{}\n", scene.name, width,
        layout_name(report.layout), report.cameras, report.frames, report.points, scene.seconds,
        outcome_name(scene.outcome),
        warnings == 0 ? "" : fmt::format(", {} warning{}", warnings, warnings == 1 ? "" : "s"));
  }
  return table + fmt::format("{} done, {} unchanged, {} failed", result.count(BatchOutcome::kDone),
                             result.count(BatchOutcome::kUnchanged),
                             result.count(BatchOutcome::kFailed));
}

json batch_json(const BatchResult& result, const fs::path& out) {
  json list = json::array();
  for (const BatchScene& scene : result.scenes) {
    json line = scene.outcome == BatchOutcome::kFailed ? json{{"error", scene.error}}
                                                       : report_json(scene.report);
    line["name"] = scene.name;
    line["out"] = (out / scene.name).string();
    line["outcome"] = outcome_name(scene.outcome);
    line["seconds"] = scene.seconds;
    list.push_back(std::move(line));
  }
  return list;
}

}  // namespace tessera
