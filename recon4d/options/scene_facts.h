// What: what presets ask of a scene: how much there is to see of it.
// Not: options (train_options.h).
#pragma once
#include "ingest/scene.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Of its training split; images need not be loaded.
SceneFacts facts_of(const Scene& scene);

}  // namespace tessera
