// The times of the frames of all clips on the clock of the rig.
#pragma once
#include <vector>

#include "ingest/capture/capture.h"

namespace tessera {

/// Of each clip, seconds; capture.cameras has the offset of each clock.
std::vector<std::vector<double>> clip_times(const Capture& capture);

}  // namespace tessera
