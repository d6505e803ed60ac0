// What: a model drawn into training frames, a batch at a time, and what is left of each image
//       when its truth is taken away.
// Not: gradients by parameters, nor sums per Gaussian (contributions.h).
#pragma once
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

  int64_t count() const { return int64_t(frames.size()); }
};

/// All training frames in the order of their timesteps; where there are more than `most` > 0, those
/// of about so many: whole timesteps, evenly spread over the clip, or, where there is one timestep,
/// `most` of its frames. `gain` is left empty.
FrameSample sample_training_frames(const Scene& scene, int64_t most = 0);

/// Backend and model, in the host's memory, must outlive it; the model must not change.
class ScoringPass {
 public:
  ScoringPass(Backend& backend, const GaussianModel& model);

  /// Draws frames [begin, end) of `at` as one batch; both calls below are of this batch.
  void draw(const FrameSample& at, int64_t begin, int64_t end);
  /// Image · gain − truth, 0 where a mask ignores the pixel: [3·pixels] as Images::colour, on the
  /// host.
  const Buffer<float>& residual() const { return residual_; }
  /// Sums of splats over their pixels, on the host.
  struct SplatSums {
    Buffer<SplatSensitivity<float>> sum;  // [S] of x: the residual, or what was given
    Buffer<int64_t> first_of;             // [N + 1] first splat of each Gaussian
  };
  /// `x`: [3·pixels] on the host, in place of the residual; empty: the residual.
  const SplatSums& sums(Span<const float> x = {});
  /// The splats themselves, [S], on the host.
  const Buffer<Splat<float>>& splats();
  const ViewBatch<float>& views() const { return pipeline_.batch(); }

 private:
  Backend& backend_;
  const GaussianModel& model_;
  GaussianSet static_set_, dynamic_set_;  // where the backend can read them
  Buffer<float> environment_;
  Pipeline<float> pipeline_;
  std::vector<Buffer<uint8_t>> truth_, mask_;  // of a batch
  Buffer<float> residual_;
  SplatSums sums_;
  Buffer<Splat<float>> splats_;
};

}  // namespace tessera
