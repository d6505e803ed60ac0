// The displacement of a point to the neighbouring timesteps, from the images of several cameras.
// Source: registration (Lucas, Kanade 1981) with one displacement in space for the windows of all
// cameras, as in scene flow [Vedula99]; gradients of the template [Baker04].
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "ingest/cloud/grey_pyramid.h"
#include "ingest/scene.h"

namespace tessera {

/// A camera that sees the point, with its images a timestep before and after.
struct MotionView {
  struct Other {
    const Frame* frame;
    const GreyPyramid* image;
    double steps;  // time from the key frame by the distance of two timesteps: about −1 or 1
  };
  const Frame* key;
  const GreyPyramid* image;
  std::vector<Other> others;
  glm::dvec3 offset{0};  // of the point at this key frame's time from its place, world units
};

/// How well a displacement explains the images.
struct MotionScore {
  double difference = 0;  // mean over windows of their mean absolute differences, levels
  int agreeing = 0;       // views whose windows agree with the key frame's
  double information = 0;  // least eigenvalue of Σ Jᵀ J over the agreeing views, levels² a pixel²
};

/// Minimises over d, the displacement of point p in a timestep,
///   E(d) = Σ_c Σ_f w_cf Σ_x ( I_cf(π_cf(p + s_f d) + x) − I_c(π_c(p) + x) )²
/// with c the views, f a view's other frames, s_f their `steps`, x the pixels of a window, I levels
/// less the window's mean and π the cameras. Gauss–Newton on each level of the pyramids, coarse to
/// fine:
///   (Σ w s² Pᵀ A P + λ 1) δ = −Σ w s Pᵀ Σ_x ∇I_c(x) r_cf(x),   A = Σ_x ∇I_c ∇I_cᵀ,   P = ∂π/∂p
/// and w_cf = 1 / (1 + m²/σ²) with m the window's mean absolute difference, so that a view in which
/// something else passes has a small weight.
class PointMotion {
 public:
  /// `pixel`: size of a pixel at the point, world units: displacements here are in pixels, as
  /// vectors of the world divided by it.
  PointMotion(const glm::dvec3& point, double pixel, std::vector<MotionView> views);
  ~PointMotion();

  /// The minimum that is reached from `start`, beginning at that level of the pyramids.
  glm::dvec3 refined(glm::dvec3 start, int coarsest) const;
  /// At the finest level.
  MotionScore score(const glm::dvec3& displacement) const;

 private:
  struct Template;  // a view's window at a level, and its derivatives

  bool step(int level, glm::dvec3& displacement) const;
  glm::dvec3 moved(const MotionView& view, const glm::dvec3& displacement, double steps) const;

  glm::dvec3 point_;
  double pixel_;
  std::vector<MotionView> views_;
  std::array<std::vector<std::optional<Template>>, size_t(kPyramidLevels)> templates_;
};

}  // namespace tessera
