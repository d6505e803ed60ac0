// The text of report.json, and the page of the program with that data in it.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// Of report.json (docs/reference/report-json.md).
constexpr int kReportSchema = 1;

/// UTF-8; bytes that are none are replaced.
std::string report_text(const nlohmann::json& report);
/// One HTML file that needs no other but the images that `report` has by address. Errors:
/// InputError where the program was built without pages.
std::string filled_report_page(const nlohmann::json& report);

}  // namespace tessera
