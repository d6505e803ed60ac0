// Moving pixels of training frames.
#include "recon4d/training/moving_pixels.h"

#include "kernels/math/photometric.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/temporal_scores.h"

namespace tessera {

FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames) {
  FrameMasks masks;
  DynamicRegions regions(scene);
  for (const int place : frames) {
    const Frame& frame = scene.frames[size_t(place)];
    const Span<const uint8_t> frame_mask = used_mask(frame);
    std::vector<uint8_t>& mask = masks.emplace_back(regions.mask_of(frame));
    if (mask.empty() && !frame_mask.empty()) mask.assign(size_t(frame_mask.size), 0);
    for (size_t p = 0; p < mask.size(); ++p)
      mask[p] = !is_used(frame_mask, p) ? 0 : mask[p] != 0 ? kMovingPixel : 1;
  }
  return masks;
}

}  // namespace tessera
