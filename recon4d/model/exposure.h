// The colour of training images, learnt beside the Gaussians: an RGB gain per camera or per image,
// or an affine map per camera. It is no part of a model, and scores and renderings do not use it.
// The product and its gradient are in kernels/math/colour_map.h. A common map could be exchanged
// with the colours of the Gaussians, so the mean gain of all rows is exactly 1 per channel, and the
// mean of affine maps is the identity; colours are then those of the mean camera. Source: failure
// mode B10.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/math/colour_map.h"
#include "recon4d/model/learnt_rows.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Which row each training frame has, and what the rows are: cameras or frames, by their names.
struct ExposureRows {
  std::vector<int32_t> of_frame;   // [training frames]; none: nothing is learnt
  std::vector<std::string> names;  // [R]
};

/// `frames`: places of the training frames in the scene. Errors: InputError: a single row, whose
/// map is the identity whatever it looks like; frames that were composited on a background of
/// light, which has no exposure.
ExposureRows exposure_rows(const Scene& scene, const std::vector<int>& frames,
                           const TrainOptions& options);

/// Numbers of a row: 3 log gains RGB, or M = A − I, column by column, then o of x = A·c + o.
constexpr int exposure_width(ExposureGains gains) {
  return gains == ExposureGains::kAffine ? 12 : 3;
}

/// [R] as the loss applies them. Gains are exp(log gain) over their mean, as multiples of 2⁻¹⁸ that
/// a float holds exactly and whose sum is R to the last bit, in whatever order it is taken.
std::vector<ColourMap<double>> colour_maps_of(const LearntRows& state);

/// A step of Adam for the rows of a batch, which may repeat: of log gains by g·dL/dg; of affine
/// maps, at a tenth of the rate, by their gradient and that of 10⁻³·Σ(‖M‖² + ‖o‖²) over all rows.
/// Then all rows are shifted to the gauge: gains, which are held within three stops thereafter, and
/// affine terms, each held within a half before.
void step_exposure(const std::vector<int32_t>& rows, const std::vector<ColourMap<double>>& d_maps,
                   double rate, LearntRows& state);

/// {"by": "camera" | "frame", "gains": {name: [r, g, b]}}, or {"by": "affine", "maps": {name:
/// {"matrix": [[…] three rows], "offset": [r, g, b]}}}: the rendered image times these is the
/// training image.
nlohmann::json exposure_json(const ExposureRows& rows, const LearntRows& state,
                             const TrainOptions& options);

/// The way back, without moments. Errors: InputError that starts with `where`: a row that `json`
/// has not, or values of another kind.
LearntRows exposure_of_json(const nlohmann::json& json, const ExposureRows& rows,
                            const TrainOptions& options, const std::string& where);

}  // namespace tessera
