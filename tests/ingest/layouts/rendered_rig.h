// Videos of a textured room by cameras that do not move, ray-traced without the program's renderer,
// with their true poses.
#pragma once
#include <filesystem>
#include <vector>

#include "ingest/scene.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/camera.h"

namespace tessera::testing {

struct RenderedRig {
  int cameras = 8, frames = 1;
  int width = 320, height = 240;
  double pixel_aspect = 1;  // width of a pixel by its height
  double panel_step = 0;    // world units a frame that a textured panel moves; 0: there is no panel
  int blue_camera = -1;     // in this one's images blue is 255; others stay below 165
  bool clocks_agree = false;  // false: camera i runs i frames late
};

/// The true cameras: on an arc, some above others, all looking into the room.
std::vector<Camera> true_cameras(const RenderedRig& rig);
/// Distance of a point to the nearest surface of the room or the panel.
double distance_to_surface(const glm::dvec3& point);
Image8 rendered_image(const RenderedRig& rig, int camera, int frame);
/// Writes cam00.mp4 … into `folder`; their timelines are as they were written.
std::vector<RigClip> write_rig(const std::filesystem::path& folder, const RenderedRig& rig);
/// A clip of any video, with the times at which its frames are shown.
RigClip clip_of(const std::filesystem::path& video);

}  // namespace tessera::testing
