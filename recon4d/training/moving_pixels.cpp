// Moving pixels of training frames.
#include "recon4d/training/moving_pixels.h"

#include "kernels/math/photometric.h"
#include "recon4d/evaluation/temporal_scores.h"

namespace tessera {

FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames) {
  FrameMasks masks;
  DynamicRegions regions(scene);
  for (const int place : frames) {
    const Frame& frame = scene.frames[size_t(place)];
    const std::vector<uint8_t>& frame_mask = frame.mask.data;
    std::vector<uint8_t>& mask = masks.emplace_back(regions.mask_of(frame));
    if (mask.empty() && !frame_mask.empty()) mask.assign(frame_mask.size(), 0);
    for (size_t p = 0; p < mask.size(); ++p)
      mask[p] = !frame_mask.empty() && frame_mask[p] == 0 ? 0 : mask[p] != 0 ? kMovingPixel : 1;
  }
  return masks;
}

}  // namespace tessera
