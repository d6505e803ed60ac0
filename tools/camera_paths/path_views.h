// The views of a video for --path: poses, lenses and timesteps.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/video/frame_rate.h"

namespace tessera {

struct PathChoice {
  std::string path;                     // orbit, spiral, or a transforms file of key frames
  std::filesystem::path cameras;        // the rig; empty: the scene that the run folder names
  std::string split;                    // of the rig's or the file's frames; empty: all
  FrameRate fps{30, 1};                 // of the video
  std::optional<double> seconds, rate;  // length of the video; speed of the clip in it
  std::optional<double> time;           // a fixed timestep, normalised
  std::string size;                     // "WxH"; empty: of the first camera
  bool for_video = false;               // sizes must be even
};

struct DrawnModel {
  const GaussianModel& model;
  std::filesystem::path named;  // what people call it; its scene has the rig
  bool is_splats = false;       // of another program: up is −y
};

/// Checks what can be checked before a model is read. Errors: InputError naming the option: no such
/// path, rate or size, odd sizes for a video, too many frames, a rig for a file.
void check_path_choice(const PathChoice& choice);

/// Views named frame_0000 … (more digits when needed), all of one size.
///
/// Orbit and spiral: without `seconds` whole rounds of the clip, 6 to 60 s. An orbit of a model
/// without a rig goes around its middle with a lens of 50°; up is then +z, and −y in splats of
/// other programs. A file: its poses one by one, or, with `seconds`, a smooth path through them.
/// Timesteps: `time`; else those of the file, unless a `rate` is given; else the clip at `rate`
/// (default 1) of its normal speed, over and over.
/// Warns of an orbit around a rig that looks one way.
/// Errors: InputError naming the option: no such path, no rig for a spiral, a rig for a file, no
/// such size, odd sizes for a video, too many frames.
std::vector<NamedView> path_views(const PathChoice& choice, const DrawnModel& drawn,
                                  std::vector<std::string>& warnings);

}  // namespace tessera
