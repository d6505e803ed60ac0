// Formats the warnings among the findings of orientation and exposure as lines.
#include "ingest/checks/camera_warnings.h"

#include "ingest/checks/exposure.h"
#include "ingest/checks/orientation.h"

namespace tessera {

std::vector<std::string> camera_warnings(const Scene& all, const Scene& sample) {
  std::vector<std::string> lines;
  for (const Findings& findings :
       {check_orientation(all).findings, check_exposure(match_stations(sample)).findings})
    for (const Finding& finding : findings)
      if (finding.severity != Severity::kInfo)
        lines.push_back(finding.camera + " " + finding.measured + ": " + finding.advice);
  return lines;
}

}  // namespace tessera
