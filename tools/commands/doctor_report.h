// What: everything `tessera doctor` found, as text for people and as one JSON object.
// Not: the checks.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "ingest/checks/finding.h"

namespace tessera {

struct DoctorReport {
  std::string path;
  std::string kind;  // "scene", "capture (a sample of it)"
  Findings findings;
  nlohmann::json tables = nlohmann::json::object();  // by check
  double seconds = 0;
};

bool has_errors(const DoctorReport& report);
/// A line for each finding, the worst first, and a line that counts them.
std::string doctor_text(const DoctorReport& report);
nlohmann::json doctor_json(const DoctorReport& report);

}  // namespace tessera
