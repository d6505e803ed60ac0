// The data of a run's report, from the files that the run wrote. Files may be missing or be of an
// earlier version; the fields that they would fill are empty then. No file is read here and no
// image is made.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/report/run_records.h"

namespace tessera {

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
/// or empty; of a clip in windows also curves and decisions, which are those of one training.
nlohmann::json run_report(const RunRecords& records);

}  // namespace tessera
