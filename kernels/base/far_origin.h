// Worlds far from their origin: map coordinates (UTM) are millions of metres, which points and
// Gaussians in float hold to half a metre only. An origin is taken out of them, and kept beside.
#pragma once
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "kernels/base/similarity.h"

namespace tessera {

/// x ↦ x − origin.
inline Similarity less(const glm::dvec3& origin) {
  Similarity change;
  change.translation = glm::dvec3(0) - origin;  // never −0, which files would show
  return change;
}

/// What to take out of places about `centre`, which are as far as `spread` from each other: the
/// centre in round numbers, where it is a thousand times as far from 0; else 0. Of places that are
/// one but for noise: the centre in whole units, from 10⁵ units on.
inline glm::dvec3 far_origin(const glm::dvec3& centre, double spread) {
  constexpr double kFar = 1000;  // a float has 24 bits: 2⁻¹⁴ of the spread is left there
  constexpr double kOnePlace = 1e-10, kFarAlone = 1e5;
  const double far = glm::length(centre);
  const bool is_one_place = !(spread > kOnePlace * far);
  if (is_one_place ? far < kFarAlone : far <= kFar * spread) return glm::dvec3(0);
  const double step = is_one_place ? 1 : std::pow(10, std::floor(std::log10(spread)));
  return step * glm::round(centre / step);
}

}  // namespace tessera
