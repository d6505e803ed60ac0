// What may explain that COLMAP found no poses.
#pragma once
#include <string>

#include "ingest/capture/capture.h"

namespace tessera {

/// Images of other shapes or of no rig, a calibration that does not fit: to be added to a message,
/// each behind "; ".
std::string pose_hints(const Capture& capture);

}  // namespace tessera
