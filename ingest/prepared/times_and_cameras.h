// Completes frames of a transforms file by what needs all of them: times, cameras and the numbers
// of frames.
#pragma once
#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// Sets time, camera_name and frame_number of `capture.frames`, and notes how they were found.
/// Frames are sorted by split, camera and time where their cameras are not their folders. What a
/// prepared scene states stays. Errors: InputError: times that some frames lack, or that cannot
/// be told (frame_times.h).
void set_times_and_cameras(TransformsCapture& capture);

/// The same of a camera path: times as stated, and no cameras are searched.
void set_path_times(TransformsCapture& capture);

}  // namespace tessera
