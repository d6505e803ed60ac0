// What: where an image of a world shows something that changes: at its timestep and at any.
// Not: the masks of single timesteps that every capture has (layout_*.cpp).
#pragma once
#include <cstdint>
#include <vector>

#include "ingest/scene.h"
#include "tools/synth/render.h"

namespace tessera::synth {

/// [height, width] 1 where a sample meets something that changes at one of `times` (normalised).
std::vector<uint8_t> ever_covered(const World& world, const Camera& camera,
                                  const std::vector<double>& times, const StaticLayer& layer);

/// Grey: 0 what never changes in this camera, else 128 + 127 · the share of the pixel's samples
/// that meet something that changes at the image's own timestep. `ever`: as by ever_covered.
Image8 moving_image(const RenderedImage& image, const std::vector<uint8_t>& ever);

/// The instants of a clip, normalised.
std::vector<double> clip_times(const SynthOptions& options);

}  // namespace tessera::synth
