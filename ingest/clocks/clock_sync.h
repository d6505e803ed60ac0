// The offset of the clock of each camera relative to the clock of the rig, stated in a file or
// measured from the videos. The offset is added to the times of the frames; no frame is resampled.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/video/clip_frames.h"

namespace tessera {

struct ClipClock {
  double offset = 0;       // seconds added to the clip's own presentation times
  double measured = 0;     // what was measured or stated, of which `offset` keeps what is certain
  double uncertainty = 0;  // standard error of it, seconds; 0 where it was stated
  std::string source;      // "stated", "container", "audio", "motion", "none"
};

/// One entry a clip. Gauge: the median of measured offsets is 0, so that most clocks stay; stated
/// ones are kept as they are.
struct ClipClocks {
  std::vector<ClipClock> clocks;
  std::vector<std::string> warnings;  // one line each, with the camera's name
  std::vector<std::string> notes{};   // what is not known, where nothing speaks against the clocks
};

/// Errors: InputError naming file or camera and the remedy.
ClipClocks synchronise(const std::vector<RigClip>& clips, const SyncOptions& options,
                       const IngestProgress& progress);

/// Seconds for each of `names`, in their order. Text: blanks or a comma between name and seconds,
/// # begins a comment. Errors: InputError naming the file and what is wrong in it: a camera that
/// is unknown, missing or stated twice, no number.
std::vector<double> read_stated_offsets(const std::filesystem::path& path,
                                        const std::vector<std::string>& names);

/// One clock a clip, their median 0. A clip whose offset cannot be measured keeps 0 and the source
/// "none", as does one without a pose: a note, and a warning where others' clocks are off; an
/// offset within offset_limits() is left at 0, its measured value beside it. Errors: InputError: a
/// clock that drifts against the others'. Memory: 512 MB of images at most, and for each clip 17 MB
/// and 0.4 MB a frame that is compared, of which there are 24, or 72 where these do not tell.
ClipClocks synchronise_by_motion(const std::vector<RigClip>& clips, const IngestProgress& progress);

}  // namespace tessera
