// Names the cameras of a rig that film in other colours than most of them.
#pragma once
#include <string>
#include <vector>

#include "ingest/video/frame_colour.h"

namespace tessera {

/// "cam03 is HLG, the others SDR", and what to do about it; empty where all transfer curves and
/// primaries are alike. The others' colour is that of most cameras, the first one's of equally
/// many. `cameras`: names; `colours`: one a camera.
std::string mixed_colours(const std::vector<std::string>& cameras,
                          const std::vector<FrameColour>& colours);

}  // namespace tessera
