// What: how much brighter each camera records each channel than the others, from features that
//       several cameras see; and images with that divided out.
// Not: exposure that changes over time, and no held-out camera: those keep their values (gain 1).
// Space: 8-bit display values as stored, image = gain · common value.
#pragma once
#include <array>

#include "ingest/checks/finding.h"
#include "ingest/media/checks/feature_matches.h"

namespace tessera {

struct CameraGain {
  std::string camera;
  std::array<double, 3> gain{1, 1, 1};  // R, G, B
  int64_t pairs = 0;                    // matches of it that the fit used; few: gain 1
};

/// One colour seen by two cameras; channels below 0 are left out.
struct ColourPair {
  int a = 0, b = 0;
  std::array<double, 3> colour_a{}, colour_b{};
};

/// Robust (Huber) least squares of log c_a − log c_b = log g_a − log g_b for each channel. Gauge:
/// the mean gain of the cameras with matches is 1 in each channel.
std::vector<CameraGain> fit_gains(const std::vector<std::string>& cameras,
                                  const std::vector<ColourPair>& pairs);

/// The gains of the training stations from their matches.
std::vector<CameraGain> fit_exposure(const MatchedStations& matched);
/// Divides the colours by the gains, rounds and clamps; alpha is kept. 1, 3 or 4 channels.
void apply_exposure(Image8& image, const std::array<double, 3>& gain);

struct ExposureCheck {
  std::vector<CameraGain> gains;
  Findings findings;
};
ExposureCheck check_exposure(const MatchedStations& matched);

}  // namespace tessera
