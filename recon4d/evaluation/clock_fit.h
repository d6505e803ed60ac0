// By how much later than its times say a scored camera filmed, from its images and what the model
// shows around those times: the clock of a held-out camera is known to ingest alone, and one that
// is a tenth of a frame off costs moving pixels more than the model does.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "recon4d/evaluation/render.h"

namespace tessera {

/// Of each camera, normalised time, within a frame: least squares over the used pixels of its
/// `frames` (places in the scene, with pixels), by Gauss–Newton from 0. 0 where nothing in its
/// images changes with time.
std::map<std::string, double> fit_clocks(Renderer& renderer, const Scene& scene,
                                         const std::vector<int>& frames);

}  // namespace tessera
