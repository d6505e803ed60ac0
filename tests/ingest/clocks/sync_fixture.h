// A folder of videos as the clips of a rig, with the poses stored beside them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/clocks/clock_sync.h"
#include "tools/synth/synth.h"

namespace tessera::testing {

/// All *.mp4 of the folder by name, posed by its poses_bounds.npy or cameras_opencv.json.
std::vector<RigClip> clips_of(const std::filesystem::path& folder);

/// A rig of 4 cameras by `synth` as `folder`; what happens in it is spread over the clip's length.
void make_rig(const std::filesystem::path& folder, SynthOptions options);

/// Measured offset of each clip, or another value of its clock, in its frames.
std::vector<double> frames_of(const ClipClocks& clocks, const std::vector<RigClip>& clips,
                              double ClipClock::*value = &ClipClock::measured);
/// "0.01 -0.02 …" for a report.
std::string text_of(const std::vector<double>& values);

}  // namespace tessera::testing
