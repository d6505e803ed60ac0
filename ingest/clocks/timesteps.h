// Normalises the times of a capture to [0, 1], numbers its timesteps, and chooses evenly spread
// ones. Clocks are real: the times of cameras may differ by parts of a frame, so that a frame's
// timestep is a number, given once over the whole clip, and times are never compared for equality.
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
  Split split = Split::kTrain;
};

/// The number of each frame's timestep, from 0 on in the order of time; as many as `frames`.
///
/// The timesteps are the times of a reference: of the cameras that have training frames, and the
/// frame rate of most of these, the one with the most times, the first by name. Every other
/// camera's frames join the nearest of them, as far as half of the reference's median frame gap,
/// with one time a camera; what is left is grouped alone in the same way, no wider. Where no second
/// training camera has several times (a moving camera, photos) there are no clocks to differ: only
/// equal times go together. Times count as equal within a millionth of the clip.
std::vector<int64_t> timestep_numbers(const std::vector<FrameTime>& frames);

/// Sets Frame::timestep of all frames, which must be those of the whole clip.
void number_timesteps(Scene& scene);

struct Timestep {
  int64_t number = 0;       // Frame::timestep
  double time = 0;          // the median of its frames
  std::vector<int> frames;  // numbers of Scene::frames, in their order
};

/// The timesteps that training frames have, ascending, with these frames. Images need not be
/// loaded.
std::vector<Timestep> training_timesteps(const Scene& scene);

/// Numbers of the key timesteps of a clip, ascending: about every tenth of its `timesteps`, evenly
/// spread, the first and the last among them; at least 8, at most 16 and `most` (2 or more), and no
/// more than there are.
std::vector<int64_t> key_timesteps(int64_t timesteps, int64_t most);

/// Numbers of the timesteps at which moving points are searched, ascending: every second of a clip,
/// the last among them; of long clips every third, fourth … so that there are at most 48.
std::vector<int64_t> motion_timesteps(int64_t timesteps);

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
