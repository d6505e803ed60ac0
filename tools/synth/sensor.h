// Converts a rendered image to the 8-bit image of a camera: exposure, light, gains, noise,
// rounding. Motion blur and rolling shutter are not modelled.
#pragma once
#include <array>
#include <cstdint>

#include "ingest/scene.h"
#include "tools/synth/render.h"
#include "tools/synth/synth.h"

namespace tessera::synth {

/// The gain of a frame, 1 ± exposure_wobble, by seed, view (camera or split) and frame number; 1
/// for what is held out by default, cam00 of a rig and dnerf's val and test, as no training learns
/// it.
double exposure_gain(const SynthOptions& options, int view, int frame);

/// Gains of red, green and blue of a camera: all 1 without SynthOptions::camera_gains, and for
/// cam00.
std::array<double, 3> camera_gain(const SynthOptions& options, int view);

/// RGBA with straight alpha, or RGB over black. Noise touches colour only, and only where there is
/// something (alpha > 0).
Image8 expose(const RenderedImage& image, const SynthOptions& options, int channels, int view,
              int frame);

/// The image's mask as a grey image: 255 what changes, 0 what does not.
Image8 mask_image(const RenderedImage& image);

}  // namespace tessera::synth
