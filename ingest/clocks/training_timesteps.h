// What: the timesteps of a scene's training split.
// Not: how frames are grouped (timesteps.h).
#pragma once
#include "ingest/clocks/timesteps.h"
#include "ingest/scene.h"

namespace tessera {

/// Timestep::frames are numbers of scene.frames; images need not be loaded.
std::vector<Timestep> training_timesteps(const Scene& scene);

}  // namespace tessera
