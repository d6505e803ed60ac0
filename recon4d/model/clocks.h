// The clocks of the cameras, learnt beside the Gaussians: by how much later than its stated times a
// camera films. It is no part of a model, whose time is that of the mean camera: a common offset
// could be exchanged with the times of the Gaussians, so the mean of all cameras is 0.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "recon4d/model/learnt_rows.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Which row each training frame has: its camera's.
struct ClockRows {
  std::vector<int32_t> of_frame;   // [training frames]; none: nothing is learnt
  std::vector<std::string> names;  // [R]
  double frame = 0;                // frame_step of these, normalised time
};

/// Median step from frame to frame of a camera, normalised time; 0: none has two timesteps.
double frame_step(const Scene& scene, const std::vector<int>& frames);

/// `frames`: places of the training frames in the scene. Errors: InputError: clocks to be learnt of
/// a single camera, or where no camera has two timesteps.
ClockRows clock_rows(const Scene& scene, const std::vector<int>& frames,
                     const TrainOptions& options);

inline constexpr double kMostClock = 1;  // frames: farther is found by ingest, not by a gradient

/// A step of Adam for the rows of a batch, which may repeat, by the gradient of the loss by the
/// times of its views. `state`, frames, is held within kMostClock, then shifted to the gauge.
void step_clocks(const std::vector<int32_t>& rows, const std::vector<double>& d_times, double frame,
                 double rate, LearntRows& state);

/// [R] normalised time.
std::vector<double> clock_offsets_of(const LearntRows& state, double frame);

/// {name: seconds to be added to its times}; null: nothing is learnt. `duration`: seconds.
nlohmann::json clocks_json(const ClockRows& rows, const LearntRows& state, double duration);

}  // namespace tessera
