// What: order, counts and wording of findings.
// Not: their content.
#include "tools/commands/doctor_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

const char* severity_name(Severity severity) {
  constexpr const char* kNames[] = {"info", "warning", "error"};
  return kNames[int(severity)];
}

Findings sorted(Findings findings) {
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return findings;
}

int64_t count(const DoctorReport& report, Severity severity) {
  return std::count_if(report.findings.begin(), report.findings.end(),
                       [=](const Finding& finding) { return finding.severity == severity; });
}

}  // namespace

bool has_errors(const DoctorReport& report) {
  return count(report, Severity::kError) > 0;
}

std::string doctor_text(const DoctorReport& report) {
  std::string text;
  for (const Finding& finding : sorted(report.findings)) {
    text += fmt::format("{:<7}  {:<8}  ", severity_name(finding.severity), finding.check);
    if (!finding.camera.empty()) text += finding.camera + ": ";
    text += finding.measured;
    if (!finding.advice.empty()) text += ": " + finding.advice;
    text += '\n';
  }
  return text + fmt::format("{} ({}): {} errors, {} warnings, {:.1f} s", report.path, report.kind,
                            count(report, Severity::kError), count(report, Severity::kWarning),
                            report.seconds);
}

nlohmann::json doctor_json(const DoctorReport& report) {
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& finding : sorted(report.findings))
    findings.push_back({{"severity", severity_name(finding.severity)},
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
          {"tables", report.tables}};
}

}  // namespace tessera
