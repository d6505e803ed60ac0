// Scores of an evaluation that need sums over the pixels of views: those of moving and static
// pixels, the colour fit of each camera, timesteps, objects, and flicker.
#pragma once
#include <optional>
#include <vector>

#include "recon4d/evaluation/dynamic_regions.h"
#include "recon4d/evaluation/evaluate.h"

namespace tessera {

/// Looks at views, on any thread, and takes what they showed in order. Scene and options must
/// outlive it.
class PixelScores {
 public:
  /// `scored`: places of the frames that will come.
  PixelScores(const Scene& scene, const std::vector<int>& scored, const EvaluateOptions& options);

  /// The sums of a view, and in `score` what a single view has of its moving and static pixels.
  /// May be called on several threads at once. `drawn`: the image in 8 bits.
  ViewPixelSums look_at(const Frame& frame, const Image8& drawn, ViewScore& score) const;
  /// Views in the order of the scene.
  void add(const Frame& frame, const RenderedImage& image, const Image8& drawn,
           const ViewPixelSums& sums);
  /// Fills in the rest; `report` has the views that were added, in order.
  void finish(EvaluationReport& report) const;

 private:
  const EvaluateOptions& options_;
  std::optional<DynamicRegions> regions_;
  std::vector<ViewPixelSums> sums_;  // of each view
  TimestepMeter timesteps_;
  ObjectMeter objects_;
  FlickerMeter flicker_;
};

}  // namespace tessera
