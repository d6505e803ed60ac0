// Finds blurred cameras, and blurred frames of a camera.
#pragma once
#include "ingest/checks/finding.h"
#include "ingest/scene.h"

namespace tessera {

/// Deviation of the Laplacian at full size by that at half size, less 1/4, which is that of a
/// smooth image. Contrast and amount of texture cancel. −1 where there is no texture.
double sharpness(const Image8& image);

struct CameraSharpness {
  std::string camera;
  double sharpness = -1;        // median over its frames; −1: no texture
  std::string softest;          // its softest frame
  double softest_relative = 1;  // by the camera's median
};

struct SharpnessCheck {
  std::vector<CameraSharpness> cameras;
  double median = -1;
  Findings findings;
};
/// Needs pixels.
SharpnessCheck check_sharpness(const Scene& scene);

}  // namespace tessera
