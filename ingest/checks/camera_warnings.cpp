// Formats the warnings among the findings of orientation and exposure as lines.
#include "ingest/checks/camera_warnings.h"

#include "ingest/checks/camera_table.h"
#include "ingest/checks/exposure.h"
#include "ingest/checks/orientation.h"

namespace tessera {

std::vector<std::string> camera_warnings(const Scene& all, const Scene& sample,
                                         std::vector<CameraRow>& rows) {
  std::vector<std::string> lines;
  const OrientationCheck orientation = check_orientation(all);
  const ExposureCheck exposure = check_exposure(match_stations(sample));
  put_rolls(orientation.cameras, rows);
  put_gains(exposure.gains, rows);
  for (const Findings& findings : {orientation.findings, exposure.findings})
    for (const Finding& finding : findings)
      if (finding.severity != Severity::kInfo)
        lines.push_back(finding.camera + " " + finding.measured + ": " + finding.advice);
  return lines;
}

}  // namespace tessera
