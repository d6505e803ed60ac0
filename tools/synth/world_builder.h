// What: adds solids to a world; every texture seed, colour and small offset follows from one seed.
// Not: a scene (room.cpp, object.cpp, figure.cpp, patch.cpp, fast.cpp).
#pragma once
#include <cstdint>
#include <glm/glm.hpp>

#include "tools/synth/hash.h"
#include "tools/synth/world.h"

namespace tessera::synth {

class WorldBuilder {
 public:
  explicit WorldBuilder(uint32_t seed) : seed_(seed) {}

  /// A texture with its own seed and colours a little off those given, their hues drawn together:
  /// neighbours then differ in brightness more than in chroma, which 4:2:0 video halves.
  Texture texture(TextureKind kind, double cell, const glm::vec3& a, const glm::vec3& b,
                  const glm::vec3& c) {
    const uint32_t h = hash(seed_, ++count_, 1);
    const glm::vec3 mean = (a + b + c) / 3.f;
    const auto colour = [&](const glm::vec3& given, int index) {
      const glm::vec3 tinted = mean + (brightness(given) - brightness(mean));
      return varied(glm::mix(given, tinted, 0.5f), hash(h, index));
    };
    return {kind, colour(a, 0), colour(b, 1), colour(c, 2), cell, h};
  }

  /// A solid that stands still, casts and receives shadow. The reference holds until the next add.
  Solid& add(const char* name, ShapeKind kind, const glm::dvec3& half, const glm::dvec3& centre,
             const Texture& texture) {
    Solid solid;
    solid.name = name;
    solid.shape = {kind, half};
    solid.texture = texture;
    solid.motion.rest = centre;
    solid.shadows = true;
    world.solids.push_back(solid);
    return world.solids.back();
  }

  /// A solid that will be given a motion; without shadows, so that it changes its own pixels only.
  Solid& add_mover(const char* name, ShapeKind kind, const glm::dvec3& half,
                   const glm::dvec3& centre, const Texture& texture) {
    Solid& solid = add(name, kind, half, centre, texture);
    solid.moves = true;
    solid.shadows = false;
    return solid;
  }

  /// A few centimetres in the plane of the floor.
  glm::dvec3 nudge() {
    const uint32_t h = hash(seed_, ++count_, 2);
    return {0.06 * signed_unit(h), 0.06 * signed_unit(mix(h)), 0};
  }

  World world;

 private:
  static float brightness(const glm::vec3& c) { return glm::dot(c, {0.3f, 0.59f, 0.11f}); }

  static glm::vec3 varied(const glm::vec3& colour, uint32_t h) {
    const glm::vec3 shift(signed_unit(h), signed_unit(mix(h)), signed_unit(mix(h + 1)));
    return glm::clamp(colour + 0.05f * shift, 0.06f, 0.94f);
  }

  uint32_t seed_;
  int64_t count_ = 0;
};

}  // namespace tessera::synth
