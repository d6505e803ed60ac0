// A change of world in double: rotation, uniform scale and translation of points and of cameras.
// Prepared scenes and models carry the one that leads from the world of the source.
#pragma once
#include <array>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "kernels/base/camera.h"

namespace tessera {

/// x ↦ scale · rotation · x + translation. Named `b_from_a` as all transforms are.
struct Similarity {
  double scale = 1;             // > 0
  glm::dmat3 rotation{1.0};     // proper; m[column][row]
  glm::dvec3 translation{0.0};  // units of the world that it leads to

  glm::dvec3 operator()(const glm::dvec3& x) const { return scale * (rotation * x) + translation; }
  bool operator==(const Similarity&) const = default;
  bool is_identity() const { return *this == Similarity{}; }
};

inline Similarity inverse(const Similarity& b_from_a) {
  Similarity a_from_b;
  a_from_b.scale = 1 / b_from_a.scale;
  a_from_b.rotation = glm::transpose(b_from_a.rotation);
  a_from_b.translation = -a_from_b.scale * (a_from_b.rotation * b_from_a.translation);
  return a_from_b;
}

/// First b_from_a, then c_from_b.
inline Similarity compose(const Similarity& c_from_b, const Similarity& b_from_a) {
  return {c_from_b.scale * b_from_a.scale, c_from_b.rotation * b_from_a.rotation,
          c_from_b(b_from_a.translation)};
}

/// The camera that sees of world b what `camera` sees of world a; depths change by the scale.
inline Camera camera_in_world(const Similarity& b_from_a, const Camera& camera) {
  if (b_from_a.is_identity()) return camera;
  Camera moved = camera;
  moved.cam_from_world = camera.cam_from_world * glm::transpose(b_from_a.rotation);
  moved.translation = -(moved.cam_from_world * b_from_a(camera.position()));
  return moved;
}

/// As files store it, bit for bit: scale, the rotation row by row, translation.
inline constexpr size_t kSimilarityNumbers = 13;
using SimilarityNumbers = std::array<double, kSimilarityNumbers>;

inline SimilarityNumbers similarity_numbers(const Similarity& s) {
  SimilarityNumbers numbers{s.scale};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) numbers[1 + 3 * size_t(r) + size_t(c)] = s.rotation[c][r];
    numbers[10 + size_t(r)] = s.translation[r];
  }
  return numbers;
}

inline Similarity similarity_from_numbers(const SimilarityNumbers& numbers) {
  Similarity s;
  s.scale = numbers[0];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) s.rotation[c][r] = numbers[1 + 3 * size_t(r) + size_t(c)];
    s.translation[r] = numbers[10 + size_t(r)];
  }
  return s;
}

}  // namespace tessera
