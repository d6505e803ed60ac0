// A model drawn into training frames, a batch at a time, and the residual of each image against its
// truth.
#pragma once
#include <optional>
#include <vector>

#include "kernels/pipeline.h"
#include "recon4d/evaluation/frame_sample.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// What the Gaussians of a model did for the frames of a pass, where the backend works.
struct ElementBuffers {
  /// Zeros. `model`: whose Gaussians they are; `varying`: whether changes over time are summed.
  ElementBuffers(Backend& backend, const GaussianModel& model, bool varying);

  Buffer<ElementSums<float>> sums;  // [N] static set first
  Buffer<TimeVariation> variation;  // [N of the static set], or empty
};

/// Backend and model must outlive it; the model must not change. A set that lies where the backend
/// works is drawn in place, another is copied there.
class ScoringPass {
 public:
  /// `sums_elements`: whether add_to will be called.
  ScoringPass(Backend& backend, const GaussianModel& model, bool sums_elements);

  /// Draws frames [begin, end) of `sample` as one batch; all calls below are of this batch. The
  /// residual is map(image) − truth, 0 where a mask ignores the pixel.
  void draw(const FrameSample& sample, int64_t begin, int64_t end);
  /// Draws these frames of `sample` as one batch.
  void draw(const FrameSample& sample, const std::vector<int64_t>& frames);
  /// Draws the batch that `other` has drawn.
  void draw_frames_of(const ScoringPass& other);
  /// Of the residual, over pixels and channels.
  double squared_error();
  /// How much each pixel of the batch is missed, where it moves; [pixels], where the backend works.
  void missed_pixels(Span<uint8_t> missed);
  /// The residual becomes what each pixel's squared error has more than in `before`, which has
  /// drawn the same frames; in the first channel, zeros in the others.
  void compare(ScoringPass& before);
  /// Adds what every splat is to the images, with the residual for the image x.
  void add_to(ElementBuffers& elements);

 private:
  void draw_batch();

  Backend& backend_;
  const GaussianModel& model_;
  bool sums_elements_;
  std::optional<GaussianSet> copies_[2];  // static, dynamic
  std::optional<MotionNodes> nodes_;
  Buffer<float> environment_;
  Pipeline<float> pipeline_;
  std::vector<View> views_;  // of the batch
  Target target_;
  KernelSwitches kernels_;
  std::vector<Buffer<uint8_t>> truth_, mask_;  // where they were copied
};

}  // namespace tessera
