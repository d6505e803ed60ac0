// The gain of each camera in each channel relative to the other cameras: a fit to colours that two
// cameras record of the same surface, and the measurement of such colours on a point cloud. Colours
// are 8-bit display values as stored: image = gain · common value.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct CameraGain {
  std::string camera;
  std::array<double, 3> gain{1, 1, 1};  // R, G, B
  int64_t pairs = 0;                    // colours of it that the fit used; few: gain 1
};

/// One colour seen by two cameras; channels below 0 are left out.
struct ColourPair {
  int a = 0, b = 0;
  std::array<double, 3> colour_a{}, colour_b{};
};

/// Fewest colours of a camera for which its gain is significant.
inline constexpr int64_t kLeastColourPairs = 20;

/// Robust (Huber) least squares of log c_a − log c_b = log g_a − log g_b for each channel. Gauge:
/// the mean gain of the cameras with enough pairs is 1 in each channel.
std::vector<CameraGain> fit_gains(const std::vector<std::string>& cameras,
                                  const std::vector<ColourPair>& pairs);

/// Gains of the training cameras from the patches around the points of `scene.points` in the images
/// of one timestep each. Needs pixels. Without points, or with fewer than two cameras at a
/// timestep, no camera has pairs.
std::vector<CameraGain> measured_gains(const Scene& scene);

/// Largest |gain − 1| of the cameras with enough pairs; 0 where there are fewer than two.
double largest_difference(const std::vector<CameraGain>& gains);

}  // namespace tessera
