// The skirt: a flared sheet of cloth about the z axis, open at both ends. Its folds travel around
// it and its sides are pushed out in turn, as by walking legs. Nothing is simulated: each point
// moves towards and away from the axis as a function of time.
#pragma once
#include <glm/vec3.hpp>

#include "tools/synth/shape.h"

namespace tessera::synth {

/// A shape of kind kSkirt at a timestep. Points are in object space.
class Skirt {
 public:
  Skirt(const Shape& shape, double time);

  /// Distance of the cloth from the axis at the height and in the direction of `point`.
  double radius(const glm::dvec3& point) const;
  /// Depth in (begin, end) at which the ray first meets the cloth; infinite: it does not.
  double depth(const glm::dvec3& origin, const glm::dvec3& direction, double begin,
               double end) const;
  /// Away from the axis, not of unit length.
  glm::dvec3 normal(const glm::dvec3& point) const;
  /// The point in the plane of the unrolled cloth (z = 0), to which its texture is fixed.
  glm::dvec3 unrolled(const glm::dvec3& point) const;

 private:
  double gap(const glm::dvec3& point) const;  // from the cloth to the point, away from the axis

  const Shape& shape_;
  double fold_sine_, fold_cosine_;  // of the phase of the folds
  double push_;                     // of the legs, -1 to 1
};

/// Largest distance of the cloth from the axis at any time.
double skirt_reach(const Shape& shape);

}  // namespace tessera::synth
