// What: the exposure of training images: an RGB gain per camera or per image, learnt beside the
//       Gaussians so that these need not explain it.
// Not: part of a model: it is drawn with gain 1 everywhere else, in every score too. The product
//       and its gradient are the loss's (kernels/math/gain.h).
// Gauge: a common gain and the Gaussians' colours could trade; per channel the mean gain of all
//        rows is exactly 1, so colours are those of the mean exposure. Source: failure mode B10.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/buffer.h"
#include "kernels/math/symmetric.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Which row each training frame has, and what the rows are: cameras or frames, by their names.
struct ExposureRows {
  std::vector<int32_t> of_frame;   // [training frames]; none: no gains
  std::vector<std::string> names;  // [R]
};

/// `frames`: places of the training frames in the scene. Errors: InputError: a single row, whose
/// gain is 1 whatever it looks like; frames that were composited on a background of light, which
/// has no exposure.
ExposureRows exposure_rows(const Scene& scene, const std::vector<int>& frames,
                           const TrainOptions& options);

/// What is learnt, always in the host's memory.
struct ExposureState {
  Buffer<float> log_gain, moment1, moment2;  // [R, 3] RGB
  Buffer<int32_t> steps;                     // [R] of Adam so far; a row steps when it is drawn

  int64_t rows() const { return steps.size(); }
  /// Gains of 1, nothing learnt.
  void reset(int64_t rows);
  ExposureState clone() const;
};

/// [R] RGB, exp(log_gain) over its mean, as multiples of 2⁻¹⁸ that a float holds exactly and whose
/// sum is R to the last bit, in whatever order it is taken.
std::vector<Vec3<double>> gains_of(const ExposureState& state);

/// A step of Adam for the rows of a batch, which may repeat: log_gain by g·dL/dg. Then all rows are
/// shifted so that their mean gain is 1, and held within three stops.
void step_exposure(const std::vector<int32_t>& rows, const std::vector<Vec3<double>>& d_gain,
                   double rate, ExposureState& state);

/// {"by": "camera" | "frame", "gains": {name: [r, g, b]}}.
nlohmann::json exposure_json(const ExposureRows& rows, const ExposureState& state,
                             const TrainOptions& options);

}  // namespace tessera
