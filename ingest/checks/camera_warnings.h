// Warnings of cameras of a rig that differ from the others: turned ones, and darker or brighter
// ones. These checks of `doctor` are cheap enough for every preparation.
#pragma once
#include <string>
#include <vector>

#include "ingest/camera_row.h"
#include "ingest/scene.h"

namespace tessera {

/// One line each, with the camera's name and what to do. Gains and rolls go to the `rows` of the
/// cameras, where these have one. `all`: every frame, pixels are not needed;
/// `sample`: a few frames of each camera, with pixels.
std::vector<std::string> camera_warnings(const Scene& all, const Scene& sample,
                                         std::vector<CameraRow>& rows);

}  // namespace tessera
