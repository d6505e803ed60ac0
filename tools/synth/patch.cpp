// What: the patch: the room without its movers, and one turning, swaying ball whose path covers a
//       given share of the image; nothing else ever changes.
// Not: the masks of what it covers (moving_masks.h).
#include <algorithm>
#include <cmath>

#include "tools/synth/moving_masks.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/world_builder.h"

namespace tessera::synth {
namespace {

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
