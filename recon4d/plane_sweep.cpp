// What: the search along a pixel's ray, and whether the pixel changes over time.
// Not: sub-pixel matching: the training moves the points.
#include "recon4d/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <map>
#include <optional>

#include "kernels/base/parallel.h"
#include "kernels/math/random.h"

namespace tessera {
namespace {

constexpr int kRadius = 2;                        // of a patch, pixels
constexpr int kDepths = 64;                       // planes, uniform in inverse depth
constexpr double kNearest = 0.25, kFarthest = 4;  // of the distance to the rig's focus
constexpr float kMostDifference = 16;             // of agreeing patches, 8-bit levels
constexpr float kLeastTexture = 3;                // mean absolute deviation of a patch, levels
constexpr float kDistinct = 1.15f;                // second valley ÷ best
constexpr float kStill = 4;                       // change over time of a still pixel, levels
constexpr int kMoments = 8;                       // moments at which a pixel is looked at

struct Patch {
  static constexpr int kSide = 2 * kRadius + 1;
  std::array<float, size_t(kSide* kSide * 3)> level;
};

bool inside(const Image8& image, int x, int y) {
  return x >= kRadius && y >= kRadius && x < image.width - kRadius && y < image.height - kRadius;
}

Patch patch_at(const Image8& image, int x, int y) {
  Patch patch;
  size_t i = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const uint8_t* row =
        image.data.data() + 3 * (size_t(y + dy) * size_t(image.width) + size_t(x - kRadius));
    for (int k = 0; k < 3 * Patch::kSide; ++k) patch.level[i++] = float(row[k]);
  }
  return patch;
}

float difference(const Patch& a, const Patch& b) {
  float sum = 0;
  for (size_t i = 0; i < a.level.size(); ++i) sum += std::abs(a.level[i] - b.level[i]);
  return sum / float(a.level.size());
}

float texture(const Patch& patch) {
  float mean = 0, deviation = 0;
  for (float level : patch.level) mean += level / float(patch.level.size());
  for (float level : patch.level) deviation += std::abs(level - mean);
  return deviation / float(patch.level.size());
}

class Sweep {
 public:
  Sweep(const Scene& scene, const CameraRig& rig) : scene_(scene), rig_(rig) {
    for (int i : scene.split_indices(Split::kTrain)) {
      const Frame& frame = scene.frames[size_t(i)];
      moments_[frame.time].push_back(i);
      cameras_[frame.camera_name].push_back(i);
    }
    for (const auto& [time, frames] : moments_)
      if (frames.size() >= 3) usable_.insert(usable_.end(), frames.begin(), frames.end());
  }
  bool usable() const { return !usable_.empty(); }

  std::optional<SweptPoint> find(const RandomBlock& random) const {
    const Frame& frame = scene_.frames[size_t(usable_[random.word[0] % uint32_t(usable_.size())])];
    const int x = int(uniform(random.word[1]) * float(frame.image.width));
    const int y = int(uniform(random.word[2]) * float(frame.image.height));
    if (!inside(frame.image, x, y)) return std::nullopt;
    const Patch patch = patch_at(frame.image, x, y);
    if (texture(patch) < kLeastTexture) return std::nullopt;
    std::array<float, kDepths> cost;
    for (int k = 0; k < kDepths; ++k) cost[size_t(k)] = disagreement(frame, patch, x, y, k);
    const int best = int(std::min_element(cost.begin(), cost.end()) - cost.begin());
    if (!(cost[size_t(best)] < kMostDifference) || !distinct(cost, best)) return std::nullopt;
    const glm::dvec3 point = on_ray(frame.camera, x, y, vertex(cost, best));
    const uint8_t* rgb =
        frame.image.data.data() + 3 * (size_t(y) * size_t(frame.image.width) + size_t(x));
    return SweptPoint{
        glm::vec3(point), {rgb[0], rgb[1], rgb[2]}, float(frame.time), still(frame, patch, x, y)};
  }

 private:
  /// Plane k, which may be fractional.
  glm::dvec3 on_ray(const Camera& camera, int x, int y, double k) const {
    const double nearest = 1 / (kNearest * rig_.distance),
                 farthest = 1 / (kFarthest * rig_.distance);
    const double depth = 1 / (farthest + (nearest - farthest) * (k + 0.5) / kDepths);
    const glm::dvec3 in_cam((x + 0.5 - camera.cx) / camera.fl_x * depth,
                            (y + 0.5 - camera.cy) / camera.fl_y * depth, depth);
    return glm::transpose(camera.cam_from_world) * (in_cam - camera.translation);
  }

  /// Mean over the better half of the other cameras, so that occluded ones have no say.
  float disagreement(const Frame& frame, const Patch& patch, int x, int y, int k) const {
    const glm::dvec3 point = on_ray(frame.camera, x, y, k);
    std::vector<float> costs;
    for (int i : moments_.at(frame.time)) {
      const Frame& other = scene_.frames[size_t(i)];
      if (&other == &frame) continue;
      const Camera& camera = other.camera;
      const glm::dvec3 p = camera.cam_from_world * point + camera.translation;
      if (p.z <= 0) continue;
      const double u = camera.fl_x * p.x / p.z + camera.cx, v = camera.fl_y * p.y / p.z + camera.cy;
      if (!(u >= 0 && v >= 0 && u < other.image.width && v < other.image.height)) continue;
      if (inside(other.image, int(u), int(v)))
        costs.push_back(difference(patch, patch_at(other.image, int(u), int(v))));
    }
    if (costs.size() < 2) return 255;
    const size_t half = std::max<size_t>(2, (costs.size() + 1) / 2);
    std::partial_sort(costs.begin(), costs.begin() + long(half), costs.end());
    float sum = 0;
    for (size_t i = 0; i < half; ++i) sum += costs[i];
    return sum / float(half);
  }

  /// No other valley is nearly as deep.
  static bool distinct(const std::array<float, kDepths>& cost, int best) {
    for (int k = 0; k < kDepths; ++k)
      if (std::abs(k - best) > 2 && cost[size_t(k)] < kDistinct * cost[size_t(best)]) return false;
    return true;
  }

  /// Vertex of the parabola through the best plane and its neighbours.
  static double vertex(const std::array<float, kDepths>& cost, int best) {
    if (best == 0 || best == kDepths - 1) return best;
    const double a = cost[size_t(best - 1)], b = cost[size_t(best)], c = cost[size_t(best + 1)];
    const double curvature = a - 2 * b + c;
    return curvature > 0 ? best + 0.5 * (a - c) / curvature : best;
  }

  bool still(const Frame& frame, const Patch& patch, int x, int y) const {
    const std::vector<int>& frames = cameras_.at(frame.camera_name);
    const size_t step = std::max<size_t>(1, frames.size() / kMoments);
    for (size_t i = 0; i < frames.size(); i += step) {
      const Frame& other = scene_.frames[size_t(frames[i])];
      if (other.camera.cam_from_world != frame.camera.cam_from_world ||
          other.camera.translation != frame.camera.translation)
        return true;  // the camera moves: the pixel tells nothing
      if (difference(patch, patch_at(other.image, x, y)) > kStill) return false;
    }
    return true;
  }

  const Scene& scene_;
  const CameraRig& rig_;
  std::map<double, std::vector<int>> moments_;       // time → training frames
  std::map<std::string, std::vector<int>> cameras_;  // camera → its training frames
  std::vector<int> usable_;                          // frames with two others of the moment
};

}  // namespace

std::vector<SweptPoint> plane_sweep(const Scene& scene, const CameraRig& rig, int64_t candidates,
                                    uint64_t seed) {
  constexpr int64_t kGrain = 64;  // candidates per task
  const Sweep sweep(scene, rig);
  std::vector<SweptPoint> points;
  if (!sweep.usable()) return points;
  std::vector<std::optional<SweptPoint>> found(static_cast<size_t>(candidates));
  parallel_for(candidates, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      found[size_t(i)] = sweep.find(philox(seed, RandomStream::kInitialise, uint64_t(i), 2));
  });
  for (const std::optional<SweptPoint>& point : found)
    if (point) points.push_back(*point);
  return points;
}

}  // namespace tessera
