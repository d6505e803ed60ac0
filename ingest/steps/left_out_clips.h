// Leaves cameras of a rig out of a capture, with a line that says why.
#pragma once
#include <string>
#include <vector>

#include "ingest/capture/capture.h"
#include "ingest/ingest.h"

namespace tessera {

/// Leaves out the clips whose entry of `keep` is 0; `seen` describes why. Errors: InputError
/// `refusal`: `strict`, or fewer than two are left.
void leave_out_clips(const std::string& seen, const std::string& refusal,
                     const std::vector<char>& keep, bool strict, Capture& capture);

/// Leaves out the clips, all posed, whose lens has no undistorted image (pinhole_view.h), as above.
void leave_out_bad_lenses(const IngestOptions& options, Capture& capture);

}  // namespace tessera
