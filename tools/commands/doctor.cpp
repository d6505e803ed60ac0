// `tessera doctor` checks a capture or scene before a training, and prints the findings as text or
// as one JSON object. The input is not changed. doctor_checks.h runs the checks.
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "ingest/camera_table_text.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/derived/thinned_scene.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/cache_folder.h"
#include "ingest/files/folders.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/counted.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/base/seconds_since.h"
#include "tools/cli/command.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/commands/doctor_checks.h"
#include "tools/session/locks.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

Findings sorted(Findings findings) {
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return findings;
}

int64_t count(const DoctorReport& report, Severity severity) {
  return std::count_if(report.findings.begin(), report.findings.end(),
                       [=](const Finding& finding) { return finding.severity == severity; });
}

bool has_errors(const DoctorReport& report) {
  return count(report, Severity::kError) > 0;
}

/// The table of cameras, a line for each finding, the worst first, and a line that counts them.
std::string doctor_text(const DoctorReport& report) {
  std::string text;
  for (const std::string& line : camera_table_lines(report.cameras)) text += line + '\n';
  for (const Finding& finding : sorted(report.findings)) {
    text += fmt::format("{:<7}  {:<8}  ", name_of(finding.severity), finding.check);
    if (!finding.camera.empty()) text += finding.camera + ": ";
    text += finding.measured;
    if (!finding.advice.empty()) text += ": " + finding.advice;
    text += '\n';
  }
  return text + fmt::format("{} ({}): {}, {}, {:.1f} s", report.path, report.kind,
                            counted(count(report, Severity::kError), "error"),
                            counted(count(report, Severity::kWarning), "warning"), report.seconds);
}

nlohmann::json doctor_json(const DoctorReport& report) {
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& finding : sorted(report.findings))
    findings.push_back({{"severity", name_of(finding.severity)},
                        {"check", finding.check},
                        {"camera", finding.camera},
                        {"measured", finding.measured},
                        {"advice", finding.advice}});
  return {{"path", report.path},
          {"kind", report.kind},
          {"errors", count(report, Severity::kError)},
          {"warnings", count(report, Severity::kWarning)},
          {"seconds", report.seconds},
          {"findings", std::move(findings)},
          {"camera_table", camera_table_json(report.cameras)},
          {"tables", report.tables}};
}

namespace fs = std::filesystem;

struct DoctorRequest {
  std::string path;
  IngestArguments ingest;
  std::string windows = "auto";
  int threads = 0;
  bool json = false;
};

/// Whether the folder is looked at as it is; a COLMAP model beside images holds more than a
/// transforms file.
bool is_scene(const fs::path& folder) {
  return is_prepared_scene(folder) || (opens_as_scene(folder) && find_colmap_model(folder).empty());
}

/// The temporary folder is removed: a log that the message names is kept in the user's cache
/// folder, one for each name of a capture, and named there instead.
std::string with_kept_logs(std::string message, const fs::path& temporary,
                           const fs::path& capture) {
  const fs::path cache = user_cache_folder();
  if (cache.empty()) return message;
  for (const auto& entry : fs::recursive_directory_iterator(temporary)) {
    const std::string log = entry.path().string();
    const size_t place = message.find(log);
    if (entry.path().extension() != ".log" || place == std::string::npos) continue;
    const fs::path name = fs::weakly_canonical(capture).filename();
    const fs::path kept =
        cache / fmt::format("doctor-{}-{}", name.string(), entry.path().filename().string());
    make_folder(cache);
    fs::copy_file(entry.path(), kept, fs::copy_options::overwrite_existing);
    message.replace(place, log.size(), kept.string());
  }
  return message;
}

IngestReport ingest_into(const fs::path& folder, const fs::path& temporary, const fs::path& capture,
                         IngestOptions options) {
  options.sample = true;
  ProgressBar bar("doctor");
  try {
    const IngestReport ingested = ingest_capture(
        capture, folder, options, [&](std::string_view what, int64_t done, int64_t total) {
          stop_if_interrupted();
          bar.update(done, total, what);
        });
    bar.clear();
    return ingested;
  } catch (const InputError& error) {
    bar.clear();
    throw InputError(with_kept_logs(error.what(), temporary, capture));
  }
}

void examine_capture(const fs::path& capture, const IngestOptions& options, DoctorReport& report) {
  const TemporaryFolder temporary("doctor");
  const fs::path folder = temporary.path() / "scene";
  const IngestReport ingested = ingest_into(folder, temporary.path(), capture, options);
  report.cameras = ingested.camera_table;
  for (const std::string& note : ingested.notes)
    report.findings.push_back({Severity::kInfo, "ingest", "", note, ""});
  for (const std::string& warning : ingested.warnings)
    report.findings.push_back({Severity::kWarning, "ingest", "", warning, ""});
  report.findings.push_back(
      {Severity::kInfo, "ingest", "",
       "checked a sample: a few timesteps of videos, images at most 960 wide",
       "run doctor on the prepared scene for times and forecast of the whole"});
  examine(thinned_scene(folder, {}), folder, {}, report);
}

int doctor(const DoctorRequest& request) {
  set_thread_count(request.threads);
  const auto begin = std::chrono::steady_clock::now();
  const WindowWish wish = parse_windows(request.windows);
  refuse_trained(request.path, "capture or scene");
  DoctorReport report;
  report.path = request.path;
  if (is_scene(request.path)) {
    const SceneLock in_use(request.path, SceneLock::Use::kRead);
    report.kind = "scene";
    examine(thinned_scene(request.path, {}), request.path, wish, report);
  } else {
    report.kind = "a sample of the capture";
    examine_capture(request.path, resolve_ingest(request.ingest), report);
  }
  report.seconds = seconds_since(begin);
  print_result(request.json, doctor_json(report), doctor_text(report));
  return has_errors(report) ? kExitFailed : kExitDone;
}

}  // namespace

void add_doctor_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("doctor", "check a capture or scene before hours are spent on it");
  const auto request = std::make_shared<DoctorRequest>();
  command->add_option("path", request->path, "capture or prepared scene")->required();
  add_ingest_options(*command, request->ingest);
  command
      ->add_option("--windows", request->windows,
                   "prepared scene: forecast as it is trained with this (tessera train --windows)")
      ->capture_default_str();
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return doctor(*request); }; });
}

}  // namespace tessera
