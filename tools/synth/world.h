// A world: solids with shape, texture, motion and lifetime, one light, and the builder that adds
// solids. Units are metres, z is up, and the floor of the room is at z = 0.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/synth/motion.h"
#include "tools/synth/shape.h"
#include "tools/synth/synth.h"
#include "tools/synth/texture.h"

namespace tessera::synth {

/// Times t with begin <= t < end, normalised.
struct Lifetime {
  double begin = -1, end = 2;
  bool whole_clip() const { return begin <= 0 && end > 1; }
  bool contains(double time) const { return time >= begin && time < end; }
};

struct Solid {
  std::string name;
  Shape shape;
  Texture texture;
  Motion motion;
  std::vector<Joint> joints;  // that carry the motion, the root first
  Lifetime lifetime;
  bool moves = false;    // false: shown as at t = 0, whatever the motion is
  bool shadows = false;  // casts and receives the light's shadow; only for what never moves
};

/// Lambert from a point light without fall-off, plus ambient light that is weaker from below.
struct Light {
  glm::dvec3 position{0, 0, 5};
  double diffuse = 0.55, ambient = 0.45;
  double specular = 0;  // Blinn–Phong strength
};

struct World {
  std::vector<Solid> solids;
  Light light;
  glm::dvec3 target{0.0};  // what the cameras look at
};

/// The worlds of the table in synth.cpp. `ball`: radius of the mover of `patch`, metres.
World build_world(SynthScene scene, uint64_t seed, double specular, double ball = 0.3);

/// `room`: floor, walls, ceiling, furniture and the movers (room.cpp).
World build_room(uint32_t seed);
/// `object`: a toy on a base plate (object.cpp).
World build_object(uint32_t seed);
/// `figure`: a marching figure with cloth (figure.cpp).
World build_figure(uint32_t seed);
/// `patch`: the room, and a ball of that radius as its only mover (room.cpp).
World build_patch(uint32_t seed, double radius);
/// `fast`: the room with fast movers in the place of its own (fast.cpp).
World build_fast(uint32_t seed);
/// The radius at which the path of the ball covers options.moving_share of cam00's image.
double patch_radius(const SynthOptions& options);

/// Adds solids to a world; every texture seed, colour and small offset follows from one seed.
class WorldBuilder {
 public:
  explicit WorldBuilder(uint32_t seed) : seed_(seed) {}

  /// A texture with its own seed and colours a little off those given, their hues drawn together:
  /// neighbours then differ in brightness more than in chroma, which 4:2:0 video halves.
  Texture texture(TextureKind kind, double cell, const glm::vec3& a, const glm::vec3& b,
                  const glm::vec3& c);

  /// A solid that stands still, casts and receives shadow. The reference holds until the next add.
  Solid& add(const char* name, ShapeKind kind, const glm::dvec3& half, const glm::dvec3& centre,
             const Texture& texture);

  /// A solid that will be given a motion; without shadows, so that it changes its own pixels only.
  Solid& add_mover(const char* name, ShapeKind kind, const glm::dvec3& half,
                   const glm::dvec3& centre, const Texture& texture);

  /// A few centimetres in the plane of the floor.
  glm::dvec3 nudge();

  World world;

 private:
  uint32_t seed_;
  int64_t count_ = 0;
};

}  // namespace tessera::synth
