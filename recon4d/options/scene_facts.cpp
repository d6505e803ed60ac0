// What: cameras counted once, however many frames they took.
// Not: images.
#include "recon4d/options/scene_facts.h"

#include "kernels/base/camera_rig.h"

namespace tessera {

SceneFacts facts_of(const Scene& scene) {
  SceneFacts facts;
  facts.still = scene.is_static;
  for (const Camera& camera : make_camera_rig(scene.training_cameras()).cameras)
    facts.camera_pixels += int64_t(camera.width) * camera.height;
  return facts;
}

}  // namespace tessera
