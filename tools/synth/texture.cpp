// The texture functions. They are not filtered: the renderer supersamples.
#include "tools/synth/texture.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "tools/synth/hash.h"

namespace tessera::synth {
namespace {

/// Value noise in [0, 1]: random values on the integer lattice, smoothly interpolated.
double value_noise(const glm::dvec3& p, uint32_t seed) {
  const glm::dvec3 base = glm::floor(p), f = p - base, s = f * f * (3.0 - 2.0 * f);
  const int64_t x = int64_t(base.x), y = int64_t(base.y), z = int64_t(base.z);
  double corner[2];
  for (int k = 0; k < 2; ++k) {
    const double a = unit(hash(seed, x, y, z + k)), b = unit(hash(seed, x + 1, y, z + k));
    const double c = unit(hash(seed, x, y + 1, z + k)), d = unit(hash(seed, x + 1, y + 1, z + k));
    corner[k] = glm::mix(glm::mix(a, b, s.x), glm::mix(c, d, s.x), s.y);
  }
  return glm::mix(corner[0], corner[1], s.z);
}

double layered_noise(const glm::dvec3& p, uint32_t seed) {
  return 0.57 * value_noise(p, seed) + 0.29 * value_noise(p * 2.03, seed + 1) +
         0.14 * value_noise(p * 4.01, seed + 2);
}

glm::vec3 blend(const glm::vec3& a, const glm::vec3& b, double amount) {
  return a + (b - a) * float(amount);
}

/// Speckle that gives flat areas something to match: a factor around 1.
float grain(const glm::dvec3& p, uint32_t seed) {
  return float(0.86 + 0.28 * layered_noise(p * 6.0, seed + 77));
}

glm::dvec2 along_surface(const glm::dvec3& p, int axis) {
  return axis == 0 ? glm::dvec2(p.y, p.z) : axis == 1 ? glm::dvec2(p.x, p.z) : glm::dvec2(p);
}

glm::vec3 checker(const Texture& t, const glm::dvec3& p, int axis) {
  const glm::dvec2 cell = glm::floor(along_surface(p, axis) / t.cell);
  const bool odd = (int64_t(cell.x) + int64_t(cell.y) + axis) & 1;
  const uint32_t h = hash(t.seed, int64_t(cell.x), int64_t(cell.y), axis);
  const float shade = float(0.85 + 0.3 * unit(h));
  return (odd ? t.b : t.a) * shade * grain(p, t.seed);
}

glm::vec3 brick(const Texture& t, const glm::dvec3& p, int axis) {
  glm::dvec2 uv = along_surface(p, axis) / glm::dvec2(t.cell, 0.45 * t.cell);
  const double row = std::floor(uv.y);
  uv.x += 0.5 * (int64_t(row) & 1);
  const double column = std::floor(uv.x), du = uv.x - column, dv = uv.y - row;
  if (du < 0.07 || dv < 0.15) return t.c * grain(p, t.seed);
  const uint32_t h = hash(t.seed, int64_t(column), int64_t(row), axis);
  return blend(t.a, t.b, unit(h)) * float(0.8 + 0.35 * unit(mix(h))) * grain(p, t.seed);
}

glm::vec3 planks(const Texture& t, const glm::dvec3& p, int axis) {
  const glm::dvec2 uv = along_surface(p, axis);
  const double board = std::floor(uv.y / t.cell), v = uv.y / t.cell - board;
  const uint32_t row = hash(t.seed, int64_t(board), axis);
  const double length = 5 * t.cell, shifted = uv.x / length + 7 * unit(row);
  const double piece = std::floor(shifted), u = shifted - piece;
  if (v < 0.08 || u < 0.016) return t.c;
  const uint32_t h = hash(row, int64_t(piece));
  const glm::dvec3 fibre(shifted * 6, uv.y / t.cell * 3.2, unit(h) * 50);
  const double tone = 0.45 * unit(mix(h)) + 0.55 * layered_noise(fibre, t.seed);
  return blend(t.a, t.b, tone) * grain(p, t.seed);
}

/// Whether q (in [-0.5, 0.5]², turned at random) lies on the glyph of that number.
bool on_glyph(const glm::dvec2& q, uint32_t glyph) {
  const double x = std::abs(q.x), y = std::abs(q.y);
  switch (glyph % 4) {
    case 0:
      return x * x + y * y < 0.11;
    case 1:
      return x < 0.42 && y < 0.13;
    case 2:
      return x < 0.27 && y < 0.27;
    default:
      return std::min(x, y) < 0.1 && std::max(x, y) < 0.38;
  }
}

glm::vec3 patches(const Texture& t, const glm::dvec3& p, int axis) {
  const glm::dvec2 uv = along_surface(p, axis) / t.cell, cell = glm::floor(uv);
  const uint32_t h = hash(t.seed, int64_t(cell.x), int64_t(cell.y), axis);
  const glm::dvec2 q = uv - cell - 0.5;
  const double angle = 3.14159265 * unit(mix(h + 1)), c = std::cos(angle), s = std::sin(angle);
  const glm::dvec2 turned(c * q.x + s * q.y, c * q.y - s * q.x);
  const glm::vec3 ground = blend(t.a, t.b, unit(mix(h + 2)));
  const glm::vec3 ink = blend(t.c, t.a, 0.35 * unit(mix(h + 3)));
  return (on_glyph(turned, h) ? ink : ground) * grain(p, t.seed);
}

glm::vec3 marble(const Texture& t, const glm::dvec3& p) {
  const double raw = 8 * layered_noise(p / t.cell, t.seed), band = std::floor(raw);
  const double edge = glm::smoothstep(0.7, 1.0, raw - band);  // steps keep contours to match
  const double level = std::clamp((band + edge - 1.5) / 5, 0.0, 1.0);
  const glm::vec3 colour =
      level < 0.5 ? blend(t.a, t.b, 2 * level) : blend(t.b, t.c, 2 * level - 1);
  return colour * grain(p, t.seed);
}

}  // namespace

glm::vec3 sample(const Texture& texture, const glm::dvec3& point, int axis) {
  switch (texture.kind) {
    case TextureKind::kPlain:
      return texture.a;
    case TextureKind::kChecker:
      return checker(texture, point, axis);
    case TextureKind::kBrick:
      return brick(texture, point, axis);
    case TextureKind::kPlanks:
      return planks(texture, point, axis);
    case TextureKind::kPatches:
      return patches(texture, point, axis);
    case TextureKind::kMarble:
      return marble(texture, point);
  }
  return texture.a;
}

}  // namespace tessera::synth
