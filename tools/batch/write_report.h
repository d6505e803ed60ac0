// Writes the report of a batch: OUT/report/index.html, report.json and report.csv.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

struct ReportRequest {
  std::filesystem::path out;  // of the batch
  bool images = true;         // of the views of each scene and variant
  std::string backend = "auto";
};

/// The contents of report.json. Images are those of the report of one run of each scene and
/// variant, which is written into its run folder where it is older than the model. Views that
/// cannot be rendered are named in the page. Errors: InputError: no batch, the folder cannot be
/// written; Interrupted.
nlohmann::json write_report(const ReportRequest& request);

}  // namespace tessera
