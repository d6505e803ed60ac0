// Writes the report of a batch: OUT/report/index.html, report.csv, report.json and charts.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

struct ReportRequest {
  std::filesystem::path out;  // of the batch
  int64_t images = 3;         // held-out views of each scene, one of more than 100; 0: none
  std::string backend = "auto";
};

/// The contents of report.json. Views that cannot be rendered are named in the page. Errors:
/// InputError: no batch, the folder cannot be written; Interrupted.
nlohmann::json write_report(const ReportRequest& request);

}  // namespace tessera
