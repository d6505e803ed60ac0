// Procedural textures: a colour for each point of an object's own (undeformed) space. Detail is
// above about 4 cm, so that modest supersampling suffices.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>

namespace tessera::synth {

enum class TextureKind {
  kPlain,    // colour a
  kChecker,  // a and b, each square a little different
  kBrick,    // bricks from a to b in mortar c
  kPlanks,   // boards from a to b with grain, gaps c
  kPatches,  // a cell each: ground from a to b, one glyph (disc, bar, square, cross) in c
  kMarble,   // layered value noise in bands from a over b to c
};

struct Texture {
  TextureKind kind = TextureKind::kPlain;
  glm::vec3 a{0.5f}, b{0.5f}, c{0.5f};  // sRGB in [0, 1]
  double cell = 0.2;                    // size of a square, brick, glyph or blob; world units
  uint32_t seed = 0;
};

/// Colour at `point` (object space, world units) of a surface whose normal is nearest to `axis`
/// (0, 1, 2); the other two coordinates run along the surface.
glm::vec3 sample(const Texture& texture, const glm::dvec3& point, int axis);

}  // namespace tessera::synth
