// What: the cameras of a rig, for players to look through, and how fast it filmed.
// Not: every view of a scene (camera_views.h).
#pragma once
#include <string>

#include "static3d/tessera4d/manifest.h"
#include "tools/camera_paths/camera_views.h"

namespace tessera {

struct Rig {
  std::vector<PlayerCamera> cameras;  // in the model's world; each place once, at most 32
  double fps = 0;                     // 0: not known
};

/// Of the frames of a scene with that time axis, in whose world the model is.
Rig rig_of_views(const std::vector<NamedView>& views, const TimeAxis& axis);
/// Of `cameras` (a scene folder or transforms file), else of the scene that the run folder
/// `model` was trained on, where that is still there, else none. Errors: InputError: `cameras` that
/// cannot be read.
Rig rig_of(const std::string& cameras, const std::string& model_path, const GaussianModel& model);

}  // namespace tessera
