// What: a scene's name to its world; the static room is the room with its movers held.
// Not: what is in the worlds (room.cpp, object.cpp, figure.cpp, patch.cpp, fast.cpp).
#include "tools/synth/world.h"

#include <vector>

#include "tools/synth/hash.h"

namespace tessera::synth {

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
