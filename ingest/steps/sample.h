// How much of a capture is taken: all that the options ask for, or of it a sample for a diagnosis.
#pragma once
#include "ingest/capture/capture.h"
#include "ingest/clocks/frame_window.h"
#include "ingest/ingest.h"

namespace tessera {

/// The window of the options; of a sample a handful of timesteps of the shortest clip.
FrameWindow window_of(const Capture& capture, const IngestOptions& options);

/// The scale of the options; of a sample as much smaller as makes the first image 960 pixels wide.
double scale_of(const Capture& capture, const IngestOptions& options);

}  // namespace tessera
