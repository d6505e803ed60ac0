// Masks of the training frames in which the pixels that move are marked, so that the loss can give
// them more weight.
// Source: the moving pixels of the scores (recon4d/evaluation/temporal_scores.h).
#pragma once
#include "recon4d/training/frame_cache.h"

namespace tessera {

/// [frames] each [height, width]: 0 where the frame's own mask ignores a pixel, kMovingPixel where
/// it differs from the median over time of its camera, else 1. Empty where the camera moves or has
/// fewer than three timesteps and the frame has no mask. `frames`: places in the scene.
FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames);

}  // namespace tessera
