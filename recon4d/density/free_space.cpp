// Means are compared on the host, a set at a time.
#include "recon4d/density/free_space.h"

#include <algorithm>

#include "kernels/base/camera_rig.h"
#include "recon4d/model/element_edits.h"

namespace tessera {
namespace {

bool is_before(const Camera& camera, const glm::dvec3& point, double distance) {
  const double depth = (camera.cam_from_world * point + camera.translation).z;
  return depth < distance && sees(camera, point, 0);
}

}  // namespace

std::array<DensityReport, 2> prune_free_space(Backend& backend, const std::vector<Camera>& cameras,
                                              double distance, TrainState& state) {
  const StageTimer timer(backend.clock(), kDensity);
  std::array<DensityReport, 2> reports;
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    DensityReport& report = reports[size_t(k)];
    report.before = report.after = set.count();
    if (!state.trains(k)) continue;
    Buffer<float> means;  // on the host
    means.copy_from(set.group(kMean).value);
    std::vector<int64_t> kept;
    for (int64_t n = 0; n < report.before; ++n) {
      const glm::dvec3 mean(means[3 * n], means[3 * n + 1], means[3 * n + 2]);
      if (std::none_of(cameras.begin(), cameras.end(),
                       [&](const Camera& camera) { return is_before(camera, mean, distance); }))
        kept.push_back(n);
    }
    report.after = int64_t(kept.size());
    report.pruned = report.before - report.after;
    if (report.pruned > 0) keep_elements(backend, kept, set, state.statistics[k]);
  }
  return reports;
}

}  // namespace tessera
