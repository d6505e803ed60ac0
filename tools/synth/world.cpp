// Builds the world of a named scene; the static room is the room without motion. All textures,
// colours and small offsets follow from one seed.
#include "tools/synth/world.h"

#include <vector>

#include "tools/synth/hash.h"

namespace tessera::synth {
namespace {

float brightness(const glm::vec3& c) {
  return glm::dot(c, {0.3f, 0.59f, 0.11f});
}

glm::vec3 varied(const glm::vec3& colour, uint32_t h) {
  const glm::vec3 shift(signed_unit(h), signed_unit(mix(h)), signed_unit(mix(h + 1)));
  return glm::clamp(colour + 0.05f * shift, 0.06f, 0.94f);
}

}  // namespace

Texture WorldBuilder::texture(TextureKind kind, double cell, const glm::vec3& a, const glm::vec3& b,
                              const glm::vec3& c) {
  const uint32_t h = hash(seed_, ++count_, 1);
  const glm::vec3 mean = (a + b + c) / 3.f;
  const auto colour = [&](const glm::vec3& given, int index) {
    const glm::vec3 tinted = mean + (brightness(given) - brightness(mean));
    return varied(glm::mix(given, tinted, 0.5f), hash(h, index));
  };
  return {kind, colour(a, 0), colour(b, 1), colour(c, 2), cell, h};
}

Solid& WorldBuilder::add(const char* name, ShapeKind kind, const glm::dvec3& half,
                         const glm::dvec3& centre, const Texture& texture) {
  Solid solid;
  solid.name = name;
  solid.shape = {kind, half};
  solid.texture = texture;
  solid.motion.rest = centre;
  solid.shadows = true;
  world.solids.push_back(solid);
  return world.solids.back();
}

Solid& WorldBuilder::add_mover(const char* name, ShapeKind kind, const glm::dvec3& half,
                               const glm::dvec3& centre, const Texture& texture) {
  Solid& solid = add(name, kind, half, centre, texture);
  solid.moves = true;
  solid.shadows = false;
  return solid;
}

glm::dvec3 WorldBuilder::nudge() {
  const uint32_t h = hash(seed_, ++count_, 2);
  return {0.06 * signed_unit(h), 0.06 * signed_unit(mix(h)), 0};
}

World build_world(SynthScene scene, uint64_t seed, double specular, double ball) {
  const uint32_t folded = hash(uint32_t(seed), int64_t(seed >> 32));
  World world = scene == SynthScene::kObject   ? build_object(folded)
                : scene == SynthScene::kFigure ? build_figure(folded)
                : scene == SynthScene::kPatch  ? build_patch(folded, ball)
                : scene == SynthScene::kFast   ? build_fast(folded)
                                               : build_room(folded);
  world.light.specular = specular;
  if (scene == SynthScene::kRoomStatic) {
    std::erase_if(world.solids, [](const Solid& s) { return !s.lifetime.whole_clip(); });
    for (Solid& solid : world.solids) solid.moves = false;
  }
  return world;
}

}  // namespace tessera::synth
