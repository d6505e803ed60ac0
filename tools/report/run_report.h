// The data of a run's report, from the files that the run wrote. Files may be missing or be of an
// earlier version; the fields that they would fill are empty then. No file is read here and no
// image is made.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The files of a run; null or empty where there is none.
struct RunRecords {
  nlohmann::json config, metrics;  // RUN/config.json, RUN/metrics.json
  nlohmann::json stages;           // OUT/stages.json of `tessera run`
  std::string log;                 // RUN/log.jsonl
  nlohmann::json trained{};        // what `tessera train --json` printed, for a run without a log
};

struct ScoredView {
  std::string name, camera;
  double time = 0;  // normalised
  double psnr = 0;  // dB
  std::optional<double> psnr_dynamic, psnr_static;
};

/// In the order of the scene.
std::vector<ScoredView> scored_views(const nlohmann::json& metrics);

/// The run as an entry of `runs` in report.json, schema 1 (docs/reference/report-json.md), but for
/// what write_run_report adds: id, title, images, files and their bytes. What is not known is null
/// or empty.
nlohmann::json run_report(const RunRecords& records);

}  // namespace tessera
