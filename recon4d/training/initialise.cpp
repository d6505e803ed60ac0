// Conversion of points to Gaussians: scales from neighbours, colours, and a spread over time; and
// the mean colour of the images as the first environment.
#include "recon4d/training/initialise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/environment.h"
#include "kernels/math/random.h"
#include "recon4d/model/new_gaussian.h"
#include "recon4d/options/train_options.h"
#include "recon4d/training/nearest_points.h"

namespace tessera {
namespace {

/// A point and what is known of it.
struct InitialPoint {
  glm::vec3 position;
  std::array<uint8_t, 3> colour;
  std::optional<float> time;  // normalised time at which it was seen
  std::optional<bool> still;  // whether it never moves
  glm::vec3 velocity{0};      // world units per unit of normalised time
  bool lasts = false;         // still, in a dynamic Gaussian
};

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

void add_random_points(const Scene& scene, const CameraRig& rig, const TrainOptions& options,
                       int64_t count, std::vector<InitialPoint>& points) {
  const bool boxed = options.init_extent > 0 || scene.had_alpha;
  const double half = options.init_extent > 0 ? options.init_extent : rig.half_view;
  for (int64_t i = 0; i < count; ++i) {
    const RandomBlock random =
        philox(uint64_t(options.seed), RandomStream::kInitialise, uint64_t(i));
    const glm::dvec3 p = boxed ? point_in_box(rig, half, random) : point_in_view(rig, random);
    const bool seen =
        std::any_of(rig.cameras.begin(), rig.cameras.end(),
                    [&](const Camera& camera) { return sees(camera, p, options.near_plane); });
    if (seen || !options.carve) points.push_back({glm::vec3(p), {128, 128, 128}, {}, {}, {}});
  }
}

std::vector<InitialPoint> random_points(const Scene& scene, const CameraRig& rig,
                                        const TrainOptions& options, std::string& source) {
  std::vector<InitialPoint> points;
  add_random_points(scene, rig, options, options.init_points, points);
  if (points.empty() && options.init_points > 0)
    throw InputError(
        "no initial point lies in the view of a training camera; pass --init-extent with the half "
        "size of the scene in world units, or give a point cloud");
  source = fmt::format("random, {} points", points.size());
  return points;
}

InitialPoint point_of(const PointCloud& cloud, size_t i) {
  InitialPoint point{cloud.position[i], cloud.colour[i], {}, {}, {}};
  if (!cloud.time.empty() && std::isfinite(cloud.time[i])) point.time = cloud.time[i];
  if (!cloud.still.empty() && cloud.still[i] != PointCloud::kStillUnknown)
    point.still = cloud.still[i] == 1;
  if (!cloud.velocity.empty()) point.velocity = cloud.velocity[i];
  return point;
}

/// At most init_points of the cloud, evenly strided, so that no point is taken twice. A cloud that
/// was found in images lacks what has no texture: a share of random points is added to it.
std::vector<InitialPoint> cloud_points(const Scene& scene, const CameraRig& rig,
                                       const TrainOptions& options, std::string& source) {
  constexpr double kRandomShare = 0.1;
  const PointCloud& cloud = scene.points;
  const auto count = int64_t(cloud.position.size());
  const int64_t taken = std::min(count, options.init_points);
  std::vector<InitialPoint> points;
  for (int64_t i = 0; i < taken; ++i) points.push_back(point_of(cloud, size_t(i * count / taken)));
  source = fmt::format("point cloud, {} of {} points", taken, count);
  if (cloud.still.empty()) return points;
  add_random_points(scene, rig, options, std::llround(kRandomShare * double(taken)), points);
  source += fmt::format(", and {} at random", int64_t(points.size()) - taken);
  return points;
}

/// Keeps at most `limit` of the points, evenly strided.
void thin_out(std::vector<InitialPoint>& points, int64_t limit, std::string& source) {
  const int64_t count = int64_t(points.size());
  if (count <= limit) return;
  for (int64_t i = 0; i < limit; ++i) points[size_t(i)] = points[size_t(i * count / limit)];
  points.resize(size_t(limit));
  source += fmt::format(", subsampled to {}", limit);
}

/// Gaussians that there may be beside those of a shared set.
int64_t room_beside(const GaussianSet* shared, int64_t limit) {
  return shared == nullptr ? limit : std::max<int64_t>(1, limit - shared->count());
}

/// Fills Gaussian n of `set`.
void place(const InitialPoint& point, float squared_distance, const TrainOptions& options,
           GaussianSet& set, int64_t n) {
  constexpr float kMinSquaredDistance = 1e-7f;  // [3DGS]
  NewGaussian gaussian;
  for (int k = 0; k < 3; ++k) {
    gaussian.position[k] = point.position[k];
    gaussian.colour[k] = float(point.colour[size_t(k)]) / 255.0f;
    gaussian.velocity[k] = point.velocity[k];
  }
  gaussian.log_scale = 0.5f * std::log(std::max(kMinSquaredDistance, squared_distance)) +
                       float(std::log(options.init_scale_factor));
  gaussian.opacity = options.init_opacity;
  gaussian.time_scale = point.lasts ? 1 : options.init_time_scale;
  // when it was seen, else uniform over the clip and a tenth beyond either end  [method D.4]
  const RandomBlock random =
      philox(uint64_t(options.seed), RandomStream::kInitialise, uint64_t(n), 1);
  gaussian.mean_time =
      point.lasts ? 0.5f : point.time.value_or(1.2f * uniform(random.word[0]) - 0.1f);
  write_gaussian(gaussian, set, n);
}

/// Share of the points of which nothing is known that start static: that of still ones among those
/// of which it is, where motion is looked at; no less than options.static_fraction.
double static_share(const std::vector<InitialPoint>& points, const TrainOptions& options) {
  int64_t known = 0, still = 0;
  for (const InitialPoint& point : points)
    if (point.still) {
      ++known;
      still += *point.still;
    }
  if (known == 0 || !options.split_by_motion) return options.static_fraction;
  return std::max(options.static_fraction, double(still) / double(known));
}

/// 1 for points of the static set: all of a static scene and of one that nodes will carry; still
/// points; else an even share of the rest.
std::vector<uint8_t> static_choice(const std::vector<InitialPoint>& points, const Scene& scene,
                                   const TrainOptions& options) {
  const bool all =
      scene.is_static || options.motion == Motion::kNone || options.motion == Motion::kNodes;
  std::vector<uint8_t> chosen(points.size(), 0);
  const double share = static_share(points, options);
  double due = 0;  // static points owed by the share so far
  for (size_t i = 0; i < points.size(); ++i) {
    if (all || (options.split_by_motion && points[i].still)) {
      chosen[i] = all || *points[i].still;
      continue;
    }
    due += share;
    chosen[i] = due >= 1 - 1e-9;
    if (chosen[i]) due -= 1;
  }
  return chosen;
}

/// Leaves out still points that Gaussians of `shared` show: within two distances of points; all
/// others become dynamic.
void leave_to(const GaussianSet& shared, std::vector<InitialPoint>& points) {
  constexpr float kSpacings = 2;
  std::vector<glm::vec3> positions, means;
  for (const InitialPoint& point : points) positions.push_back(point.position);
  const GaussianSpans<const float> values = shared.values();
  for (int64_t n = 0; n < values.count; ++n) means.push_back(load3(values.at(kMean, n)));
  const std::vector<float> spacing = mean_squared_neighbour_distance(positions),
                           distance = squared_distance_to_nearest(positions, means);
  std::vector<InitialPoint> kept;
  for (size_t i = 0; i < points.size(); ++i) {
    const bool is_still = points[i].still.value_or(false);
    if (is_still && distance[i] <= kSpacings * kSpacings * spacing[i]) continue;
    kept.push_back(points[i]);
    kept.back().lasts = is_still;
    kept.back().still = false;
  }
  points = std::move(kept);
}

/// Of the pixels that masks use; grey where there are none.
std::array<float, 3> mean_colour(const Scene& scene) {
  std::array<double, 3> sum{};
  double pixels = 0;
  for (const int f : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(f)];
    for (size_t p = 0; p < frame.image.data.size() / 3; ++p) {
      if (!frame.mask.data().empty() && frame.mask.data()[p] == 0) continue;
      for (size_t c = 0; c < 3; ++c) sum[c] += frame.image.data[3 * p + c] / 255.0;
      ++pixels;
    }
  }
  std::array<float, 3> mean{0.5f, 0.5f, 0.5f};
  for (size_t c = 0; c < 3 && pixels > 0; ++c) mean[c] = float(sum[c] / pixels);
  return mean;
}

}  // namespace

Initialisation initialise_model(const Scene& scene, const CameraRig& rig,
                                const TrainOptions& options, const GaussianSet* shared) {
  check(options.near_plane > 0, "initialise_model: the near plane is not resolved");
  Initialisation result;
  std::vector<InitialPoint> points = scene.points.position.empty()
                                         ? random_points(scene, rig, options, result.source)
                                         : cloud_points(scene, rig, options, result.source);
  if (shared != nullptr) leave_to(*shared, points);
  if (growth_limit(options) > 0)
    thin_out(points, room_beside(shared, growth_limit(options)), result.source);
  std::vector<glm::vec3> positions;
  positions.reserve(points.size());
  for (const InitialPoint& point : points) positions.push_back(point.position);
  const std::vector<float> squared = mean_squared_neighbour_distance(positions);
  const std::vector<uint8_t> is_static = shared != nullptr ? std::vector<uint8_t>(points.size(), 0)
                                                           : static_choice(points, scene, options);

  GaussianModel& model = result.model;
  const int stored = sh_coefficients(int(options.sh_degree));
  model.static_set = GaussianSet(SetForm::kStatic, stored);
  model.dynamic_set =
      GaussianSet(dynamic_form(options), stored, host_memory(), int(options.sh_time_degree));
  const int64_t statics = std::count(is_static.begin(), is_static.end(), uint8_t{1});
  model.static_set.resize(statics);
  model.dynamic_set.resize(int64_t(points.size()) - statics);
  int64_t placed[2] = {0, 0};
  for (size_t i = 0; i < points.size(); ++i) {
    GaussianSet& set = is_static[i] ? model.static_set : model.dynamic_set;
    place(points[i], squared[i], options, set, placed[size_t(is_static[i])]++);
  }
  if (shared != nullptr) model.static_set = shared->clone_to(host_memory());
  model.time_axis = scene.time_axis;
  model.prepared_from_source = scene.prepared_from_source;
  model.background = scene.background;
  model.drawing = static_cast<const DrawingRules&>(options);
  model.drawing.sh_degree = 0;  // bands and levels become active as the schedule has them
  model.drawing.sh_time_degree = 0;
  model.train_scale = options.train_scale;
  return result;
}

EnvironmentLight first_environment(const Scene& scene, const TrainOptions& options) {
  if (scene.had_alpha)
    throw InputError(
        fmt::format("{}: has frames with alpha, whose background is known; pass --environment "
                    "false",
                    scene.path));
  EnvironmentLight environment;
  environment.height = int(options.environment_size);
  const int64_t scalars = environment_scalars(environment.height);
  for (Buffer<float>* values :
       {&environment.map.value, &environment.map.moment1, &environment.map.moment2}) {
    values->resize(scalars);
    std::fill(values->begin(), values->end(), 0.0f);
  }
  const std::array<float, 3> mean = mean_colour(scene);
  for (int64_t i = 0; i < scalars; ++i) environment.map.value[i] = mean[size_t(i % 3)];
  return environment;
}

}  // namespace tessera
