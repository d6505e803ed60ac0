// The static background of a static camera: its image without moving objects, and a mask of moving
// pixels, from a few frames spread over the clip.
#pragma once
#include <vector>

#include "ingest/scene.h"
#include "ingest/video/clip_frames.h"

namespace tessera {

struct StillImage {
  Image8 image;         // RGB, each value the median over time
  Image8 mask;          // one channel: 255 still, 0 moving
  float threshold = 0;  // 8-bit values: a pixel that deviates by more moves
};

/// Frames of a clip from which its still image is computed.
inline constexpr size_t kStillSamples = 9;

/// Up to `count` indices into the clip's frames, spread evenly, first and last among them.
std::vector<size_t> spread_frames(size_t frames, size_t count);
/// The images of the frames `chosen` (increasing).
std::vector<Image8> sample_images(const RigClip& clip, const std::vector<size_t>& chosen);
/// Of images of one size, at least one.
StillImage still_image(const std::vector<Image8>& images);
/// 255 where the image differs from the still one of its clip, 0 elsewhere.
Image8 moving_mask(const Image8& image, const StillImage& still);

}  // namespace tessera
