// What: points → Gaussians: scales from neighbours, grey or coloured, spread over time.
// Not: how points are found in pictures (ingest).
#include "recon4d/initialise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/math/random.h"
#include "recon4d/nearest_points.h"

namespace tessera {
namespace {

float logit(double p) {
  return float(std::log(p / (1 - p)));
}

/// Uniform in the box around the focus: an object whose surroundings are known to be empty.
glm::dvec3 point_in_box(const CameraRig& rig, double half, const RandomBlock& random) {
  const glm::dvec3 unit(uniform(random.word[0]), uniform(random.word[1]), uniform(random.word[2]));
  return rig.focus + half * (2.0 * unit - 1.0);
}

/// In the view of a random camera, uniform in inverse depth between a quarter of and four times
/// the distance to the focus: a room that surrounds what is looked at.
glm::dvec3 point_in_view(const CameraRig& rig, const RandomBlock& random) {
  constexpr double kNearest = 0.25, kFarthest = 4;
  const Camera& camera = rig.cameras[size_t(uniform(random.word[0]) * float(rig.cameras.size()))];
  const double inverse = (1 - uniform(random.word[1])) / (kNearest * rig.distance) +
                         uniform(random.word[1]) / (kFarthest * rig.distance);
  const double x = (uniform(random.word[2]) * camera.width - camera.cx) / camera.fl_x;
  const double y = (uniform(random.word[3]) * camera.height - camera.cy) / camera.fl_y;
  const glm::dvec3 in_cam = glm::dvec3(x, y, 1) / inverse;
  return glm::transpose(camera.cam_from_world) * (in_cam - camera.translation);
}

PointCloud random_points(const Scene& scene, const CameraRig& rig, const TrainOptions& options) {
  const bool boxed = options.init_extent > 0 || scene.had_alpha;
  const double half = options.init_extent > 0 ? options.init_extent : rig.half_view;
  PointCloud cloud;
  for (int64_t i = 0; i < options.init_points; ++i) {
    const RandomBlock random =
        philox(uint64_t(options.seed), RandomStream::kInitialise, uint64_t(i));
    const glm::dvec3 p = boxed ? point_in_box(rig, half, random) : point_in_view(rig, random);
    const bool seen =
        std::any_of(rig.cameras.begin(), rig.cameras.end(),
                    [&](const Camera& camera) { return sees(camera, p, options.near_plane); });
    if (options.carve && !seen) continue;
    cloud.position.push_back(glm::vec3(p));
    cloud.colour.push_back({128, 128, 128});
  }
  if (cloud.position.empty() && options.init_points > 0)
    throw InputError(
        "no initial point lies in the view of a training camera; pass --init-extent with the half "
        "size of the scene in world units, or give a point cloud");
  return cloud;
}

/// At most init_points of the cloud, evenly strided, so that no point is taken twice.
PointCloud share_of(const PointCloud& cloud, int64_t limit) {
  const int64_t count = int64_t(cloud.position.size());
  if (count <= limit) return cloud;
  PointCloud share;
  for (int64_t i = 0; i < limit; ++i) {
    const size_t from = size_t(i * count / limit);
    share.position.push_back(cloud.position[from]);
    share.colour.push_back(cloud.colour[from]);
  }
  return share;
}

/// Fills Gaussian n of `set` from point i.
void place(const PointCloud& cloud, size_t i, float squared_distance, const TrainOptions& options,
           GaussianSet& set, int64_t n) {
  constexpr float kMinSquaredDistance = 1e-7f;  // [3DGS]
  const GaussianSpans<float> v = set.values();
  const float log_scale = 0.5f * std::log(std::max(kMinSquaredDistance, squared_distance));
  for (int k = 0; k < 3; ++k) {
    v.at(kMean, n)[k] = cloud.position[i][k];
    v.at(kLogScale, n)[k] = log_scale;
    v.at(kSh, n)[k] = (float(cloud.colour[i][size_t(k)]) / 255.0f - 0.5f) / float(kSh0);
  }
  std::fill_n(v.at(kSh, n) + 3, set.width(kSh) - 3, 0.0f);
  const float identity[4] = {1, 0, 0, 0};
  std::copy_n(identity, 4, v.at(kRotation, n));
  *v.at(kOpacityLogit, n) = logit(options.init_opacity);
  if (set.dim() != 4) return;
  std::copy_n(identity, 4, v.at(kRotationRight, n));
  // uniform over the clip and a tenth beyond either end  [method D.4]
  const RandomBlock random =
      philox(uint64_t(options.seed), RandomStream::kInitialise, uint64_t(n), 1);
  *v.at(kMeanTime, n) = 1.2f * uniform(random.word[0]) - 0.1f;
  *v.at(kLogScaleTime, n) = float(std::log(options.init_time_scale));
}

}  // namespace

Initialisation initialise_model(const Scene& scene, const CameraRig& rig,
                                const TrainOptions& options) {
  const bool from_cloud = !scene.points.position.empty();
  const PointCloud cloud =
      from_cloud ? share_of(scene.points, options.init_points) : random_points(scene, rig, options);
  const std::vector<float> squared = mean_squared_neighbour_distance(cloud.position);
  const int64_t count = int64_t(cloud.position.size());
  const bool all_static = options.static_only || scene.is_static;
  const double share = all_static ? 1.0 : options.static_fraction;

  Initialisation result;
  GaussianModel& model = result.model;
  const int stored = sh_coefficients(int(options.sh_degree));
  model.static_set = GaussianSet(3, stored);
  model.dynamic_set = GaussianSet(4, stored);
  const int64_t statics = std::llround(share * double(count));
  model.static_set.resize(statics);
  model.dynamic_set.resize(count - statics);
  int64_t placed = 0;
  for (int64_t i = 0; i < count; ++i) {
    // spread evenly over the order of the points: i belongs to the static set when the share steps
    const bool is_static =
        placed < statics && (i + 1) * statics / std::max<int64_t>(count, 1) > placed;
    GaussianSet& set = is_static ? model.static_set : model.dynamic_set;
    place(cloud, size_t(i), squared[size_t(i)], options, set, is_static ? placed : i - placed);
    placed += is_static;
  }
  model.time_axis = scene.time_axis;
  model.background = scene.background;
  model.near_plane = options.near_plane, model.far_plane = options.far_plane;
  model.sh_degree = 0;
  result.source =
      from_cloud ? fmt::format("point cloud, {} of {} points", count, scene.points.position.size())
                 : fmt::format("random, {} points in view", count);
  return result;
}

}  // namespace tessera
