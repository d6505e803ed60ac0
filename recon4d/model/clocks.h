// The clocks of the cameras, learnt beside the Gaussians: by how much later than its stated times a
// camera films, and how much longer than stated its rolling shutter reads an image. They are no
// part of a model, whose time is that of the mean camera: a common offset could be exchanged with
// the times of the Gaussians, so the mean of all cameras is 0.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/camera.h"
#include "recon4d/model/learnt_rows.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Numbers of a row: an offset and a readout, frames.
inline constexpr int kClockWidth = 2;

/// What is added to the time and to the readout of a camera's views, normalised time; also the
/// gradient of the loss by these.
struct CameraClock {
  double offset = 0, readout = 0;
};

/// Which row each training frame has: its camera's.
struct ClockRows {
  std::vector<int32_t> of_frame;           // [training frames]; none: nothing is learnt
  std::vector<std::string> names;          // [R]
  double frame = 0;                        // frame_step of these, normalised time
  bool offsets = false, readouts = false;  // what is learnt
};

/// Median step from frame to frame of a camera, normalised time; 0: none has two timesteps.
double frame_step(const Scene& scene, const std::vector<int>& frames);

/// `frames`: places of the training frames in the scene. Errors: InputError: clocks to be learnt of
/// a single camera, or either where no camera has two timesteps.
ClockRows clock_rows(const Scene& scene, const std::vector<int>& frames,
                     const TrainOptions& options);

inline constexpr double kMostClock = 1;  // frames: farther is found by ingest, not by a gradient

/// A step of Adam for the rows of a batch, which may repeat, by the gradients of its views. `state`
/// is held within kMostClock, then its offsets are shifted to the gauge. `rate`: frames.
void step_clocks(const std::vector<int32_t>& rows, const std::vector<CameraClock>& gradients,
                 const ClockRows& learnt, double rate, LearntRows& state);

/// [R]
std::vector<CameraClock> clocks_of(const LearntRows& state, double frame);

/// A view as its camera's clock has it.
View at_clock(View view, const CameraClock& clock);

/// "clocks" and "readouts", each {name: seconds to be added to what the scene states}, or null
/// where they are not learnt. `duration`: seconds.
nlohmann::json clocks_json(const ClockRows& rows, const LearntRows& state, double duration);

}  // namespace tessera
