// What: a model drawn into training frames, a batch at a time, and what is left of each image
//       when its truth is taken away.
// Not: gradients by parameters, nor sums per Gaussian (contributions.h).
#pragma once
#include <optional>
#include <vector>

#include "ingest/scene.h"
#include "kernels/pipeline.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Training frames and how they were exposed.
struct FrameSample {
  const Scene* scene = nullptr;
  std::vector<int> frames;         // places in scene->frames, in the order of their timesteps
  std::vector<Vec3<double>> gain;  // [frames] RGB; empty: the images are compared as rendered
  KernelSwitches kernels;          // how they are drawn and looked at
  /// [frames] images and masks where the backend reads them; empty: those of the scene are copied.
  std::vector<Span<const uint8_t>> images, masks;

  int64_t count() const { return int64_t(frames.size()); }
};

/// All training frames in the order of their timesteps; where there are more than `most` > 0, those
/// of about so many: whole timesteps, evenly spread over the clip, or, where there is one timestep,
/// `most` of its frames. `gain` is left empty.
FrameSample sample_training_frames(const Scene& scene, int64_t most = 0);

/// What the Gaussians of a model did for the frames of a pass, where the backend works.
struct ElementBuffers {
  /// Zeros. `model`: whose Gaussians they are.
  ElementBuffers(Backend& backend, const GaussianModel& model);

  Buffer<ElementSums<float>> sums;  // [N] static set first
  Buffer<TimeVariation> variation;  // [N of the static set]
};

/// Backend and model must outlive it; the model must not change. A set that lies where the backend
/// works is drawn in place, another is copied there.
class ScoringPass {
 public:
  ScoringPass(Backend& backend, const GaussianModel& model);

  /// Draws frames [begin, end) of `sample` as one batch; all calls below are of this batch. The
  /// residual is image · gain − truth, 0 where a mask ignores the pixel.
  void draw(const FrameSample& sample, int64_t begin, int64_t end);
  /// Draws the batch that `other` has drawn.
  void draw_frames_of(const ScoringPass& other);
  /// Of the residual, over pixels and channels.
  double squared_error();
  /// The residual becomes what each pixel's squared error has more than in `before`, which has
  /// drawn the same frames; in the first channel, zeros in the others.
  void compare(ScoringPass& before);
  /// Adds what every splat is to the images, with the residual for the image x.
  void add_to(ElementBuffers& elements);

 private:
  void draw_batch();

  Backend& backend_;
  const GaussianModel& model_;
  std::optional<GaussianSet> copies_[2];  // static, dynamic
  Buffer<float> environment_;
  Pipeline<float> pipeline_;
  std::vector<View> views_;  // of the batch
  Target target_;
  KernelSwitches kernels_;
  std::vector<Buffer<uint8_t>> truth_, mask_;  // where they were copied
};

}  // namespace tessera
