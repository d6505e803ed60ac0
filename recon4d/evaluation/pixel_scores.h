// Scores of an evaluation that need sums over the pixels of views: those of moving and static
// pixels, the colour fit of each camera, timesteps, objects, and flicker.
#pragma once
#include <vector>

#include "recon4d/evaluation/evaluate.h"

namespace tessera {

/// Takes the scored views in order. Scene and options must outlive it.
class PixelScores {
 public:
  /// `scored`: numbers of the frames that will come.
  PixelScores(const Scene& scene, const std::vector<int>& scored, const EvaluateOptions& options);

  /// Fills in what a single view has of its moving and static pixels.
  void add(const Frame& frame, const RenderedImage& image, ViewScore& score);
  /// Fills in the rest; `report` has the views that were added, in order.
  void finish(EvaluationReport& report) const;

 private:
  const EvaluateOptions& options_;
  DynamicRegions regions_;
  std::vector<ViewPixelSums> sums_;  // of each view
  TimestepMeter timesteps_;
  ObjectMeter objects_;
  FlickerMeter flicker_;
};

}  // namespace tessera
