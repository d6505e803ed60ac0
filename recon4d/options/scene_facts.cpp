// Facts of the training split: each camera counts once, however many frames it took.
#include "recon4d/options/scene_facts.h"

#include <algorithm>
#include <map>
#include <set>

#include "kernels/base/camera_rig.h"

namespace tessera {

SceneFacts facts_of(const Scene& scene) {
  SceneFacts facts;
  facts.still = scene.is_static;
  const CameraRig rig = make_camera_rig(scene.training_cameras());
  facts.extent = rig.extent;
  for (const Camera& camera : rig.cameras)
    facts.camera_pixels += int64_t(camera.width) * camera.height;
  std::map<std::string, int64_t> frames;  // by camera
  std::set<double> times;
  for (int i : scene.split_indices(Split::kTrain)) {
    ++frames[scene.frames[size_t(i)].camera_name];
    times.insert(scene.frames[size_t(i)].time);
  }
  facts.single_view = times.size() > 1 && times.size() == scene.split_indices(Split::kTrain).size();
  for (const auto& [camera, count] : frames) facts.timesteps = std::max(facts.timesteps, count);
  facts.cameras = std::count_if(frames.begin(), frames.end(), [&](const auto& camera) {
    return 2 * camera.second >= facts.timesteps;
  });
  return facts;
}

}  // namespace tessera
