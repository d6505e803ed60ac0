// The dynamic Gaussians of a model at a timestep as static ones; the shape of each is computed
// once. Source: kernels/math/spacetime.h; [Yang24] Eqs. 8–10: Σ_c and the velocity do not depend on
// t.
#pragma once
#include <vector>

#include "kernels/math/spacetime.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// A dynamic Gaussian as motion of a static one: mean + velocity·(t − mean_time), and opacity
/// σ(logit)·exp(−½ (t − mean_time)²·precision_time), without a temporal filter.
struct MovingGaussian {
  int64_t source;              // index in the dynamic set
  Spacetime<float> spacetime;  // as the renderer computes it
  Vec3<float> mean;            // at mean_time, world units
  float opacity;               // σ(logit)
  Vec3<float> log_scale;       // axes of Σ_c
  Vec4<float> rotation;        // unit quaternion w,x,y,z
};

/// Model must outlive the slicer and stay as it is.
class Slicer {
 public:
  explicit Slicer(const GaussianModel& model);

  /// The model at normalised time t as one static set: the static Gaussians unchanged, then each
  /// dynamic one that is drawn at t with mean μ + vΔ, covariance Σ_c and opacity o·p. Those the
  /// renderer would not draw (p < 0.05, o·p < 1/255) are left out. It renders as the model does at
  /// t only when the model has sliced_direction: without, a moving Gaussian's colour is seen along
  /// the direction of its mean over time, which the slice does not have.
  GaussianSet at(double time) const;
  /// Valid dynamic Gaussians, in their order.
  const std::vector<MovingGaussian>& moving() const { return moving_; }
  /// Dynamic Gaussians that the renderer refuses: not finite, or a quaternion without length.
  int64_t invalid() const { return model_.dynamic_set.count() - int64_t(moving_.size()); }

 private:
  const GaussianModel& model_;
  std::vector<MovingGaussian> moving_;
};

}  // namespace tessera
