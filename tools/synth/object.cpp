// The object: a toy on a base plate, with parts that turn, orbit, stretch and wave, all within 1.25
// of the origin as in the scenes of D-NeRF. Rays that miss it are transparent.
#include "tools/synth/world.h"

namespace tessera::synth {
namespace {

void add_still_parts(WorldBuilder& b) {
  const Texture plate = b.texture(TextureKind::kPatches, 0.22, {.34f, .42f, .50f},
                                  {.54f, .62f, .66f}, {.90f, .82f, .58f});
  b.add("plate", ShapeKind::kCylinder, {0.95, 0.95, 0.05}, {0, 0, -0.75}, plate);
  const Texture post = b.texture(TextureKind::kChecker, 0.12, {.80f, .76f, .68f},
                                 {.42f, .30f, .24f}, {.5f, .5f, .5f});
  b.add("post", ShapeKind::kCylinder, {0.04, 0.04, 0.75}, {-0.62, 0.45, 0.05}, post);
}

void add_moving_parts(WorldBuilder& b) {
  const Texture body = b.texture(TextureKind::kPatches, 0.17, {.84f, .40f, .26f},
                                 {.92f, .64f, .34f}, {.20f, .24f, .42f});
  Motion& stretch =
      b.add_mover("body", ShapeKind::kSphere, glm::dvec3(0.42), {0, 0, -0.28}, body).motion;
  stretch.stretch = 0.3;
  stretch.stretch_cycles = 2;
  stretch.stretch_base = 0.42;
  stretch.spin_turns = 0.5;
  const Texture hat = b.texture(TextureKind::kChecker, 0.14, {.86f, .84f, .78f}, {.18f, .44f, .46f},
                                {.5f, .5f, .5f});
  Motion& lift = b.add_mover("hat", ShapeKind::kBox, {0.25, 0.25, 0.15}, {0, 0, 0.56}, hat).motion;
  lift.sway_sine = {0, 0, 0.26};
  lift.sway_cycles = 2;
  lift.spin_turns = -1;
  const Texture moon = b.texture(TextureKind::kMarble, 0.16, {.30f, .46f, .28f}, {.58f, .74f, .40f},
                                 {.92f, .90f, .72f});
  Motion& orbit =
      b.add_mover("moon", ShapeKind::kSphere, glm::dvec3(0.17), {0, 0, 0.0}, moon).motion;
  orbit.sway_sine = {0.62, 0.5, 0.16};
  orbit.sway_cosine = {0.62, -0.5, 0};
  orbit.spin_axis = {1, 0.4, 1};
  orbit.spin_turns = 1.5;
  const Texture weave = b.texture(TextureKind::kPatches, 0.16, {.44f, .24f, .52f},
                                  {.64f, .40f, .70f}, {.94f, .88f, .60f});
  Solid& flag =
      b.add_mover("flag", ShapeKind::kCloth, {0.25, 0.34, 0.12}, {-0.27, 0.45, 0.52}, weave);
  // Local y, pinned at its positive end, points from the flag to the post; local z is level.
  flag.motion.rest_rotation = turn_x(90) * turn_z(90);
  flag.shape.wave_cycles = 2;
}

}  // namespace

World build_object(uint32_t seed) {
  WorldBuilder builder(seed);
  add_still_parts(builder);
  add_moving_parts(builder);
  builder.world.light.position = {2.5, -3, 5};
  builder.world.target = {0, 0, 0};
  return builder.world;
}

}  // namespace tessera::synth
