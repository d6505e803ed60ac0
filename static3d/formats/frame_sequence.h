// A model as a numbered sequence of static files with a manifest, for players of frames. Source:
// failure modes E3, E4, E7.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "static3d/formats/splat_file.h"
#include "static3d/tessera4d/player_hints.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// One file of the sequence.
struct SequenceFrame {
  double time = 0;           // normalised
  int64_t gaussians = 0;     // written
  int64_t non_finite = 0;    // left out: a value not finite, a quaternion without length
  int64_t below_cutoff = 0;  // left out: never drawn at this time (o·p < 1/255 or p < 0.05)
  int64_t far_outliers = 0;  // beyond 10 × the scene box
  int64_t out_of_range = 0;  // left out: too far from the others for the range of the format
};

struct SequenceReport {
  std::vector<SequenceFrame> frames;
  int64_t bytes = 0;          // of the frames' files
  int64_t max_gaussians = 0;  // of a frame
  int64_t non_finite = 0;     // sums over the frames
  int64_t below_cutoff = 0, far_outliers = 0, out_of_range = 0;
};

/// (frames done, frames in all), on the caller's thread; may throw to stop.
using SequenceProgress = std::function<void(int64_t, int64_t)>;

/// "frame_0000" and the extension of the format: four digits, more where `count` frames need them.
std::string sequence_file_name(int64_t i, int64_t count, const SplatFormat& format);

/// Data of the manifest beyond the frames.
struct SequenceHints {
  std::vector<PlayerCamera> cameras;  // in the model's world
};

/// Writes frame_0000.EXTENSION … (four digits, more when needed) for `times` (normalised,
/// ascending) and, last, manifest.json. Each file appears atomically; frames of an earlier, longer
/// export are removed. Frames are made in parallel, as many at once as fit a fixed memory budget.
/// Frames show the colours of the model only when it has sliced_direction, see
/// Slicer::at. `windows`, where it has any: each frame is of the window that is drawn at its time,
/// and `model` states their drawing rules and the time axis of the clip alone. Errors: InputError:
/// no times, times that do not ascend, a folder that cannot be written; of WindowModels::load.
SequenceReport export_sequence(const GaussianModel& model, const std::filesystem::path& folder,
                               const std::vector<double>& times, const SplatFormat& format,
                               const SequenceProgress& progress = {},
                               const SequenceHints& hints = {}, const WindowModels& windows = {});

}  // namespace tessera
