// The gain of each camera in each channel from features that several cameras see, and the division
// of images by it. A gain is constant over time; held-out cameras keep gain 1. Colours are 8-bit
// display values as stored: image = gain · common value.
#pragma once
#include <array>

#include "ingest/checks/colour_gains.h"
#include "ingest/checks/feature_matches.h"
#include "ingest/checks/finding.h"

namespace tessera {

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
