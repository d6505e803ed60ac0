// What: masks joined over the timesteps of a clip.
// Not: rendering (render.cpp).
#include "tools/synth/moving_masks.h"

#include <cmath>

#include "tools/synth/ground_truth.h"

namespace tessera::synth {

std::vector<uint8_t> ever_covered(const World& world, const Camera& camera,
                                  const std::vector<double>& times, const StaticLayer& layer) {
  std::vector<uint8_t> ever(size_t(camera.width) * size_t(camera.height));
  for (const double time : times) {
    const std::vector<float> share = render(world, camera, time, layer).moving_share;
    for (size_t p = 0; p < ever.size(); ++p) ever[p] |= uint8_t(share[p] > 0);
  }
  return ever;
}

Image8 moving_image(const RenderedImage& image, const std::vector<uint8_t>& ever) {
  Image8 moving{image.width, image.height, 1, std::vector<uint8_t>(ever.size())};
  for (size_t p = 0; p < ever.size(); ++p)
    if (ever[p] != 0 || image.moving_share[p] > 0)
      moving.data[p] = uint8_t(128 + std::lround(127 * image.moving_share[p]));
  return moving;
}

std::vector<double> clip_times(const SynthOptions& options) {
  std::vector<double> times;
  for (int frame = 0; frame < options.frames; ++frame)
    times.push_back(normalised_time(options, frame));
  return times;
}

}  // namespace tessera::synth
