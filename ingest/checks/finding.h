// One result of a check: its severity, the check, the camera, the measured values and the advice.
// tools/commands/doctor.cpp formats it as text.
#pragma once
#include <string>
#include <vector>

#include "kernels/base/enum_names.h"

namespace tessera {

enum class Severity { kInfo, kWarning, kError };
template <>
inline constexpr const char* kEnumNames<Severity>[] = {"info", "warning", "error"};

struct Finding {
  Severity severity = Severity::kInfo;
  std::string check;     // "poses", "exposure", …
  std::string camera;    // empty: of no single camera
  std::string measured;  // what was seen, with numbers
  std::string advice;    // what to do; may be empty for kInfo
};
using Findings = std::vector<Finding>;

/// Cameras that are named one by one in a check before the others are only counted.
inline constexpr size_t kMostNamed = 5;

}  // namespace tessera
