// The room: six textured sides, furniture, and movers that are rigid, stretch, wave, appear and
// vanish. Cameras are in the free front part, y < -2.5 (rigs.cpp). The patch scene is the room with
// one ball whose path covers a given share of the image.
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "tools/synth/ground_truth.h"
#include "tools/synth/hash.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/world.h"

namespace tessera::synth {
namespace {

using glm::dvec3;

constexpr double kWide = 3.2, kFront = -4.7, kBack = 3.0, kHigh = 3.0;  // the room's extent

void add_sides(WorldBuilder& b) {
  const double depth = 0.5 * (kBack - kFront), middle = 0.5 * (kBack + kFront);
  const double tall = 0.5 * kHigh;
  const auto side = [&](const char* name, const dvec3& half, const dvec3& centre,
                        const glm::dmat3& turned, const Texture& texture) {
    b.add(name, ShapeKind::kQuad, half, centre, texture).motion.rest_rotation = turned;
  };
  const Texture wood = b.texture(TextureKind::kPlanks, 0.24, {.62f, .42f, .25f}, {.84f, .66f, .44f},
                                 {.22f, .14f, .09f});
  const Texture brick = b.texture(TextureKind::kBrick, 0.46, {.66f, .30f, .22f}, {.84f, .52f, .38f},
                                  {.84f, .81f, .75f});
  const Texture paper = b.texture(TextureKind::kPatches, 0.34, {.30f, .50f, .56f},
                                  {.50f, .70f, .68f}, {.90f, .84f, .60f});
  const Texture tiles = b.texture(TextureKind::kChecker, 0.42, {.80f, .77f, .68f},
                                  {.42f, .50f, .64f}, {.5f, .5f, .5f});
  const Texture stone = b.texture(TextureKind::kMarble, 0.6, {.46f, .44f, .42f}, {.70f, .67f, .62f},
                                  {.88f, .86f, .80f});
  side("floor", {kWide, depth, 0}, {0, middle, 0}, glm::dmat3(1), wood);
  side("ceiling", {kWide, depth, 0}, {0, middle, kHigh}, turn_x(180), stone);
  side("back wall", {kWide, tall, 0}, {0, kBack, tall}, turn_x(90), brick);
  side("front wall", {kWide, tall, 0}, {0, kFront, tall}, turn_x(-90), stone);
  const glm::dmat3 left = turn_z(90) * turn_x(90), right = turn_z(-90) * turn_x(90);
  side("left wall", {depth, tall, 0}, {-kWide, middle, tall}, left, paper);
  side("right wall", {depth, tall, 0}, {kWide, middle, tall}, right, tiles);
}

void add_table(WorldBuilder& b) {
  const dvec3 centre = dvec3(-1.15, 1.45, 0) + b.nudge();
  const Texture top = b.texture(TextureKind::kMarble, 0.3, {.25f, .40f, .34f}, {.45f, .62f, .50f},
                                {.86f, .88f, .74f});
  const Texture legs = b.texture(TextureKind::kBrick, 0.2, {.40f, .26f, .18f}, {.55f, .38f, .25f},
                                 {.24f, .15f, .10f});
  b.add("table", ShapeKind::kBox, {0.75, 0.5, 0.05}, centre + dvec3(0, 0, 0.78), top);
  for (const double x : {-0.65, 0.65})
    for (const double y : {-0.4, 0.4})
      b.add("leg", ShapeKind::kBox, {0.05, 0.05, 0.365}, centre + dvec3(x, y, 0.365), legs);
  const Texture ball = b.texture(TextureKind::kChecker, 0.13, {.90f, .85f, .78f},
                                 {.70f, .22f, .25f}, {.5f, .5f, .5f});
  b.add("globe", ShapeKind::kSphere, dvec3(0.24), centre + dvec3(-0.35, 0.05, 1.07), ball);
  const Texture vase = b.texture(TextureKind::kPatches, 0.12, {.20f, .30f, .58f},
                                 {.34f, .46f, .74f}, {.92f, .90f, .84f});
  b.add("vase", ShapeKind::kCylinder, {0.13, 0.13, 0.22}, centre + dvec3(0.35, 0.1, 1.05), vase);
}

void add_furniture(WorldBuilder& b) {
  add_table(b);
  const Texture cabinet = b.texture(TextureKind::kPatches, 0.26, {.64f, .48f, .20f},
                                    {.82f, .66f, .32f}, {.25f, .20f, .34f});
  b.add("cabinet", ShapeKind::kBox, {0.5, 0.4, 0.8}, dvec3(2.35, 2.1, 0.8) + b.nudge(), cabinet)
      .motion.rest_rotation = turn_z(-14);
  const Texture crate = b.texture(TextureKind::kPlanks, 0.14, {.55f, .36f, .20f},
                                  {.76f, .56f, .34f}, {.20f, .13f, .08f});
  b.add("crate", ShapeKind::kBox, {0.38, 0.38, 0.38}, dvec3(-2.3, 0.1, 0.38) + b.nudge(), crate)
      .motion.rest_rotation = turn_z(28);
  const Texture stone = b.texture(TextureKind::kMarble, 0.24, {.28f, .30f, .36f},
                                  {.56f, .58f, .62f}, {.88f, .86f, .84f});
  b.add("ball", ShapeKind::kSphere, dvec3(0.4), dvec3(2.35, 0.35, 0.4) + b.nudge(), stone);
  const Texture drum = b.texture(TextureKind::kBrick, 0.3, {.24f, .46f, .42f}, {.40f, .64f, .56f},
                                 {.88f, .84f, .66f});
  b.add("drum", ShapeKind::kCylinder, {0.3, 0.3, 0.55}, dvec3(1.05, 2.25, 0.55) + b.nudge(), drum);
  const Texture rug = b.texture(TextureKind::kPatches, 0.3, {.52f, .18f, .22f}, {.70f, .32f, .28f},
                                {.90f, .78f, .56f});
  b.add("rug", ShapeKind::kBox, {1.5, 1.0, 0.015}, {0.15, -0.3, 0.015}, rug).motion.rest_rotation =
      turn_z(8);
  const Texture image = b.texture(TextureKind::kPatches, 0.2, {.86f, .84f, .78f},
                                  {.62f, .72f, .84f}, {.18f, .22f, .40f});
  b.add("picture", ShapeKind::kBox, {0.55, 0.03, 0.4}, {0.35, kBack - 0.03, 1.85}, image);
  b.add("picture", ShapeKind::kBox, {0.03, 0.5, 0.35}, {kWide - 0.03, 0.2, 1.6}, image);
  const Texture pole = b.texture(TextureKind::kChecker, 0.1, {.72f, .70f, .66f}, {.40f, .38f, .36f},
                                 {.5f, .5f, .5f});
  b.add("pole", ShapeKind::kCylinder, {0.035, 0.035, 0.85}, {-2.05, 2.5, 2.43}, pole)
      .motion.rest_rotation = turn_z(90) * turn_x(90);
}

/// The stand of the stretching ball is furniture; everything else here moves.
void add_movers(WorldBuilder& b) {
  const Texture ball = b.texture(TextureKind::kPatches, 0.15, {.90f, .52f, .16f},
                                 {.94f, .74f, .30f}, {.16f, .24f, .44f});
  Motion& arc =
      b.add_mover("flying ball", ShapeKind::kSphere, dvec3(0.26), {0, 0.7, 1.5}, ball).motion;
  arc.sway_sine = {1.25, 0, 0};
  arc.sway_cosine = {0, 0.35, 0.32};
  arc.spin_axis = {0.3, 1, 0.2};
  arc.spin_turns = 1;
  const Texture die = b.texture(TextureKind::kChecker, 0.16, {.86f, .86f, .80f}, {.16f, .44f, .38f},
                                {.5f, .5f, .5f});
  Motion& tumble =
      b.add_mover("tumbling box", ShapeKind::kBox, dvec3(0.24), {-0.95, -0.55, 0.6}, die).motion;
  tumble.sway_sine = {0.3, 0.35, 0.08};
  tumble.spin_axis = {1, 2, 3};
  tumble.spin_turns = 0.75;
  const Texture plinth = b.texture(TextureKind::kBrick, 0.26, {.60f, .56f, .50f},
                                   {.76f, .72f, .64f}, {.34f, .32f, .30f});
  b.add("stand", ShapeKind::kCylinder, {0.42, 0.42, 0.18}, {0.75, -0.15, 0.2}, plinth);
  const Texture jelly = b.texture(TextureKind::kPatches, 0.17, {.42f, .22f, .56f},
                                  {.66f, .36f, .70f}, {.94f, .88f, .52f});
  Motion& bounce =
      b.add_mover("stretching ball", ShapeKind::kSphere, dvec3(0.32), {0.75, -0.15, 0.7}, jelly)
          .motion;
  bounce.stretch = 0.42;
  bounce.stretch_cycles = 2;
  bounce.stretch_base = 0.32;
  const Texture weave = b.texture(TextureKind::kPatches, 0.22, {.20f, .34f, .62f},
                                  {.34f, .52f, .78f}, {.94f, .86f, .70f});
  Solid& banner =
      b.add_mover("banner", ShapeKind::kCloth, {0.75, 0.55, 0.17}, {-2.05, 2.5, 1.85}, weave);
  banner.motion.rest_rotation = turn_x(90);
  banner.shape.wave_cycles = 2;
  const Texture parcel = b.texture(TextureKind::kChecker, 0.14, {.88f, .24f, .28f},
                                   {.92f, .84f, .72f}, {.5f, .5f, .5f});
  Solid& visitor =
      b.add_mover("visitor", ShapeKind::kBox, {0.24, 0.24, 0.3}, {-0.1, 0.65, 0.3}, parcel);
  visitor.motion.rest_rotation = turn_z(35);
  visitor.lifetime = {0.3, 0.65};
}

Solid patch_ball(uint32_t seed, double radius) {
  constexpr double kLeastCell = 0.05;  // of the texture, metres
  WorldBuilder builder(hash(seed, 11));
  const Texture texture =
      builder.texture(TextureKind::kPatches, std::max(kLeastCell, 0.3 * radius), {.90f, .52f, .16f},
                      {.94f, .78f, .34f}, {.12f, .20f, .46f});
  Solid ball =
      builder.add_mover("ball", ShapeKind::kSphere, glm::dvec3(radius), {0, -0.3, 1.15}, texture);
  ball.motion.sway_sine = {0.35 * radius, 0, 0};
  ball.motion.sway_cosine = {0, 0, 0.15 * radius};
  ball.motion.spin_axis = {0.3, 1, 0.2};
  ball.motion.spin_turns = 1;
  return ball;
}

}  // namespace

World build_room(uint32_t seed) {
  WorldBuilder builder(seed);
  add_sides(builder);
  add_furniture(builder);
  add_movers(builder);
  builder.world.light.position = {-0.9, -1.9, 2.85};
  builder.world.target = {0, 0.5, 1.0};
  return builder.world;
}

World build_patch(uint32_t seed, double radius) {
  World world = build_room(seed);
  std::erase_if(world.solids, [](const Solid& solid) { return solid.moves; });
  world.solids.push_back(patch_ball(seed, radius));
  return world;
}

double patch_radius(const SynthOptions& options) {
  constexpr int kWidest = 320, kMostMoments = 24, kHalvings = 14;
  const World room = build_world(options.scene, options.seed, 0);
  Camera camera = video_rig(options, room.target).front();
  const double size = std::min(1.0, double(kWidest) / camera.width);
  camera = camera.resized(int(std::lround(size * camera.width)),
                          std::max(1, int(std::lround(size * camera.height))));
  const StaticLayer layer = render_static(room, camera, std::min(options.supersampling, 3));
  const int timesteps = std::min(options.frames, kMostMoments);
  std::vector<double> times;
  for (int i = 0; i < timesteps; ++i)
    times.push_back(timesteps > 1 ? double(i) / (timesteps - 1) : 0);
  double low = 0.02, high = 1.1;  // metres; the ball then touches floor and ceiling nowhere
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const World world = build_world(options.scene, options.seed, 0, middle);
    const std::vector<uint8_t> ever = ever_covered(world, camera, times, layer);
    const auto covered = double(std::count(ever.begin(), ever.end(), 1));
    (covered < options.moving_share * double(ever.size()) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tessera::synth
