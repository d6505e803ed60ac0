// Means are compared on the host.
#include "recon4d/density/free_space.h"

#include <algorithm>

#include "kernels/base/camera_rig.h"
#include "recon4d/density/unseen.h"

namespace tessera {
namespace {

bool is_before(const Camera& camera, const glm::dvec3& point, double distance) {
  const double depth = (camera.cam_from_world * point + camera.translation).z;
  return depth < distance && sees(camera, point, 0);
}

}  // namespace

std::array<DensityReport, 2> prune_free_space(Backend& backend, const std::vector<Camera>& cameras,
                                              double distance, TrainState& state) {
  Buffer<float> means[2];  // on the host
  for (int k = 0; k < 2; ++k) means[k].copy_from(state.set(k).group(kMean).value);
  return prune_where_not(backend, state, [&](int k, int64_t n) {
    const float* const m = means[k].data() + 3 * n;
    const glm::dvec3 mean(m[0], m[1], m[2]);
    return std::none_of(cameras.begin(), cameras.end(),
                        [&](const Camera& camera) { return is_before(camera, mean, distance); });
  });
}

}  // namespace tessera
