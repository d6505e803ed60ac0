// How many pixels the training images show, by which the number of Gaussians is limited.
#pragma once
#include <optional>

#include "ingest/scene.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Lowers options.peak_gaussians to gaussians_per_pixel for each pixel that a training image, all
/// of which are loaded, shows on average: that no mask ignores and, where images have alpha, that
/// is not the background's colour. Returns those pixels; nothing where the limit stays.
std::optional<double> limit_by_shown_pixels(const Scene& scene, TrainOptions& options);

}  // namespace tessera
