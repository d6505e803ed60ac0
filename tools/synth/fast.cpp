// The fast scene: static furniture and walls of the room, two thrown balls, a swinging arm and a
// waving flag, all so fast that they move many pixels from frame to frame.
#include <string>

#include "tools/synth/hash.h"
#include "tools/synth/world.h"

namespace tessera::synth {
namespace {

using glm::dvec3;

constexpr double kGravity = 37.6;  // metres per clip²: 9.81 m/s² where 48 frames are at 24 a second
constexpr double kStandHeight = 0.6;

/// A throw from `from` to `to`, centres of the ball, between two normalised times.
void throw_ball(Solid& ball, const dvec3& from, const dvec3& to, double begin, double end) {
  const double flight = end - begin;
  Motion& motion = ball.motion;
  motion.rest = from;
  motion.gravity = {0, 0, -kGravity};
  motion.launch = (to - from) / flight - 0.5 * flight * motion.gravity;
  motion.begin = begin;
  motion.end = end;
}

dvec3 add_stand(WorldBuilder& b, double x, double y, double radius, const Texture& texture) {
  b.add("stand", ShapeKind::kCylinder, {0.15, 0.15, 0.5 * kStandHeight}, {x, y, 0.5 * kStandHeight},
        texture);
  return {x, y, kStandHeight + radius};
}

/// One ball crosses the image from left to right: cam00 sees 3.6 m there, of which it takes 1.3 m
/// in 10 of 48 frames. The other one comes from the back towards the cameras.
void add_balls(WorldBuilder& b) {
  const Texture stone = b.texture(TextureKind::kBrick, 0.16, {.60f, .56f, .50f}, {.76f, .72f, .64f},
                                  {.34f, .32f, .30f});
  constexpr double kLarge = 0.2, kSmall = 0.17;
  const Texture orange = b.texture(TextureKind::kPatches, 0.13, {.90f, .52f, .16f},
                                   {.94f, .74f, .30f}, {.16f, .24f, .44f});
  const dvec3 left = add_stand(b, -1.3, -0.35, kLarge, stone);
  const dvec3 right = add_stand(b, 1.3, -0.35, kLarge, stone);
  Solid& across = b.add_mover("thrown ball", ShapeKind::kSphere, dvec3(kLarge), left, orange);
  throw_ball(across, left, right, 0.15, 0.58);
  across.motion.spin_axis = {0.3, 1, 0.2};
  across.motion.spin_turns = 2;
  const Texture checks = b.texture(TextureKind::kChecker, 0.1, {.20f, .34f, .66f},
                                   {.90f, .88f, .80f}, {.5f, .5f, .5f});
  const dvec3 back = add_stand(b, 1.1, 1.5, kSmall, stone);
  const dvec3 front = add_stand(b, -0.6, -0.9, kSmall, stone);
  Solid& along = b.add_mover("returned ball", ShapeKind::kSphere, dvec3(kSmall), back, checks);
  throw_ball(along, back, front, 0.5, 0.93);
  along.motion.spin_axis = {1, 0.4, 0};
  along.motion.spin_turns = -2;
}

/// A part of the arm that hangs down from `top` when no joint turns, `radius` at its upper end.
void add_part(WorldBuilder& b, const char* name, const std::vector<Joint>& joints, const dvec3& top,
              double length, double radius, const Texture& texture) {
  const double tip = 0.8 * radius;
  Solid& part = b.add_mover(name, ShapeKind::kRoundCone, {tip, radius, 0.5 * length},
                            top - dvec3(0, 0, 0.5 * length), texture);
  part.joints = joints;
}

/// It swings to and fro in front of a post, its elbow and hand later than its shoulder.
void add_arm(WorldBuilder& b) {
  constexpr double kCycles = 2, kLength = 0.42;
  const dvec3 shoulder(0.1, 0.75, 1.75), across(0, 1, 0);
  const Texture post = b.texture(TextureKind::kPlanks, 0.1, {.48f, .32f, .20f}, {.66f, .48f, .32f},
                                 {.18f, .12f, .08f});
  b.add("post", ShapeKind::kBox, {0.07, 0.07, 0.95}, shoulder + dvec3(0, 0.22, -0.8), post);
  const Texture sleeve = b.texture(TextureKind::kPlanks, 0.08, {.30f, .58f, .60f},
                                   {.52f, .78f, .74f}, {.14f, .24f, .36f});
  const Texture skin = b.texture(TextureKind::kMarble, 0.11, {.80f, .56f, .42f}, {.90f, .70f, .56f},
                                 {.96f, .84f, .74f});
  const Texture glove = b.texture(TextureKind::kChecker, 0.06, {.74f, .26f, .24f},
                                  {.94f, .86f, .72f}, {.5f, .5f, .5f});
  std::vector<Joint> joints{{shoulder, {{across, {0, 48, kCycles, 0}}}, dvec3(0), {}}};
  add_part(b, "upper arm", joints, shoulder, kLength, 0.09, sleeve);
  const dvec3 elbow = shoulder - dvec3(0, 0, kLength);
  joints.push_back({elbow, {{across, {0, 40, kCycles, -0.12}}}, dvec3(0), {}});
  add_part(b, "forearm", joints, elbow, kLength, 0.07, skin);
  const dvec3 wrist = elbow - dvec3(0, 0, kLength);
  joints.push_back({wrist, {{across, {0, 30, kCycles, -0.2}}}, dvec3(0), {}});
  add_part(b, "hand", joints, wrist, 0.14, 0.075, glove);
}

/// It hangs from the pole of the room's banner.
void add_flag(WorldBuilder& b) {
  const Texture weave = b.texture(TextureKind::kPatches, 0.22, {.20f, .34f, .62f},
                                  {.34f, .52f, .78f}, {.94f, .86f, .70f});
  Solid& flag =
      b.add_mover("flag", ShapeKind::kCloth, {0.75, 0.55, 0.22}, {-2.05, 2.45, 1.85}, weave);
  flag.motion.rest_rotation = turn_x(90);
  flag.shape.wave_cycles = 6;
}

}  // namespace

World build_fast(uint32_t seed) {
  WorldBuilder builder(hash(seed, 12));
  builder.world = build_room(seed);
  std::erase_if(builder.world.solids,
                [](const Solid& solid) { return solid.moves || solid.name == "stand"; });
  add_balls(builder);
  add_arm(builder);
  add_flag(builder);
  return builder.world;
}

}  // namespace tessera::synth
