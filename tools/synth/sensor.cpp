// Exposure, light, gains and noise are functions of (seed, view, frame, pixel). The standard
// deviation of the noise is the same for every brightness.
#include "tools/synth/sensor.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/parallel.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/hash.h"
#include "tools/synth/rigs.h"

namespace tessera::synth {
namespace {

uint32_t frame_seed(const SynthOptions& options, int view, int frame) {
  return hash(uint32_t(options.seed ^ (options.seed >> 32)), view, frame, 8);
}

bool is_reference(const SynthOptions& options, int view) {
  if (options.layout == SynthLayout::kDnerf) return view != int(PoseSet::kTrain);
  return view == 0 && options.cameras > 1;
}

/// The light at a frame of a camera, 1 or SynthOptions::light_step.
double light_factor(const SynthOptions& options, int view, int frame) {
  return frame + shift_of(options, view) < 0.5 * options.frames ? 1 : options.light_step;
}

}  // namespace

double exposure_gain(const SynthOptions& options, int view, int frame) {
  if (is_reference(options, view)) return 1;
  return 1 + options.exposure_wobble * signed_unit(frame_seed(options, view, frame));
}

std::array<double, 3> camera_gain(const SynthOptions& options, int view) {
  std::array<double, 3> gain{1, 1, 1};
  if (!options.camera_gains || view == 0) return gain;
  const uint32_t seed = hash(uint32_t(options.seed ^ (options.seed >> 32)), view, 10);
  for (size_t k = 0; k < 3; ++k) gain[k] += 0.2 * signed_unit(hash(seed, int64_t(k)));
  return gain;
}

Image8 expose(const RenderedImage& image, const SynthOptions& options, int channels, int view,
              int frame) {
  const uint32_t seed = mix(frame_seed(options, view, frame));
  const double shared = exposure_gain(options, view, frame) * light_factor(options, view, frame);
  const std::array<double, 3> of_camera = camera_gain(options, view);
  float gain[3];
  for (size_t k = 0; k < 3; ++k) gain[k] = float(of_camera[k] * shared);
  Image8 exposed{image.width, image.height, channels, {}};
  const int64_t row = image.width;
  exposed.data.resize(size_t(row * image.height * channels));
  parallel_for(image.height, 16, [&](int64_t begin, int64_t end) {
    for (int64_t pixel = begin * row; pixel < end * row; ++pixel) {
      const float* from = &image.rgba[size_t(4 * pixel)];
      uint8_t* to = &exposed.data[size_t(channels * pixel)];
      const float over_black = channels == 3 ? from[3] : 1.f;
      for (int k = 0; k < 3; ++k) {
        double level = 255.0 * from[k] * over_black * gain[k];
        if (options.noise_sigma > 0 && from[3] > 0)
          level += options.noise_sigma * normal(hash(seed, pixel, k));
        to[k] = uint8_t(std::lround(std::clamp(level, 0.0, 255.0)));
      }
      if (channels == 4) to[3] = uint8_t(std::lround(255 * from[3]));
    }
  });
  return exposed;
}

Image8 mask_image(const RenderedImage& image) {
  return {image.width, image.height, 1, image.mask};
}

}  // namespace tessera::synth
