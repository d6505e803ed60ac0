// Normalises the times of a capture to [0, 1], groups the frames of several cameras into timesteps,
// and chooses evenly spread timesteps. Times of cameras may differ by parts of a frame.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// The values of a frame that determine its timestep.
struct FrameTime {
  std::string camera;
  double time = 0;  // normalised
  int index = 0;    // the caller's
};

struct Timestep {
  double time = 0;          // of the camera with the most timesteps
  std::vector<int> frames;  // FrameTime::index, in the order given
};

/// Timesteps in order of time: those of the camera that has the most (the first by name), each with
/// the frames nearest to it, as far as half of that camera's smallest frame gap. Where no camera
/// has two timesteps, frames of equal times go together.
std::vector<Timestep> group_timesteps(const std::vector<FrameTime>& frames);

/// Numbers of the key timesteps of a clip, ascending: about every tenth of its `timesteps`, evenly
/// spread, the first and the last among them; at least 8, at most 16 and `most` (2 or more), and no
/// more than there are.
std::vector<int64_t> key_timesteps(int64_t timesteps, int64_t most);

/// Numbers of the timesteps at which moving points are searched, ascending: every second of a clip,
/// the last among them; of long clips every third, fourth … so that there are at most 48.
std::vector<int64_t> motion_timesteps(int64_t timesteps);

/// Timestep::frames are numbers of scene.frames; images need not be loaded.
std::vector<Timestep> training_timesteps(const Scene& scene);

struct NormalisedTimes {
  std::vector<double> time;  // as many as were given, in [0, 1]
  TimeAxis axis;
  bool is_static = false;
};

/// time = (t − min) / (max − min), so t, 2t + 5 and t + 1.7e9 give the same. One time is static.
/// Errors: InputError that starts with `where` when several are given that are all equal, unless
/// `allow_static`.
NormalisedTimes normalise_times(const std::vector<double>& source_times, bool allow_static,
                                const std::string& where);

}  // namespace tessera
