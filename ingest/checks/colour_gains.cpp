// Iteratively reweighted least squares on a small dense system, and colours from patches around the
// points of the cloud.
#include "ingest/checks/colour_gains.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "ingest/clocks/timesteps.h"
#include "ingest/cloud/grey_patch.h"
#include "kernels/base/cholesky.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

struct LogRatio {
  size_t a, b;
  double value;
};

/// log gains of one channel with mean 0; the weak pull to 0 decides where nothing else does.
std::vector<double> solve(const std::vector<LogRatio>& ratios, const std::vector<double>& weights,
                          size_t cameras) {
  constexpr double kPull = 1e-6;
  std::vector<double> normal(cameras * cameras), right(cameras);
  for (size_t i = 0; i < cameras; ++i) normal[i * cameras + i] = kPull;
  for (size_t i = 0; i < ratios.size(); ++i) {
    const auto& [a, b, value] = ratios[i];
    const double w = weights[i];
    normal[a * cameras + a] += w;
    normal[b * cameras + b] += w;
    normal[a * cameras + b] -= w;
    normal[b * cameras + a] -= w;
    right[a] += w * value;
    right[b] -= w * value;
  }
  return Cholesky(std::move(normal), cameras).solve(std::move(right));
}

std::vector<double> log_gains(const std::vector<LogRatio>& ratios, size_t cameras) {
  constexpr int kIterations = 30;
  std::vector<double> weights(ratios.size(), 1.0), gains;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    gains = solve(ratios, weights, cameras);
    std::vector<double> residuals;
    for (const auto& [a, b, value] : ratios)
      residuals.push_back(std::abs(value - gains[a] + gains[b]));
    // 95 % efficient for a normal
    const double huber = std::max(1e-6, 1.345 * 1.4826 * median(residuals));
    for (size_t i = 0; i < weights.size(); ++i)
      weights[i] = residuals[i] <= huber ? 1 : huber / residuals[i];
  }
  return gains;
}

/// The patch around a point in a camera's image, where it lies inside and is not masked.
std::optional<Patch> patch_of(const Frame& frame, const glm::dvec3& point) {
  const Camera& camera = frame.camera;
  const glm::dvec3 p = camera.cam_from_world * point + camera.translation;
  if (p.z <= 0) return std::nullopt;
  const double u = camera.fl_x * p.x / p.z + camera.cx, v = camera.fl_y * p.y / p.z + camera.cy;
  if (!(u >= 0 && v >= 0 && u < frame.image.width && v < frame.image.height)) return std::nullopt;
  if (!has_patch(rgb_of(frame.image), int(u), int(v))) return std::nullopt;
  if (frame.mask.ignores(int(u), int(v))) return std::nullopt;
  return patch_between(rgb_of(frame.image), u, v);
}

/// Neither so dark that rounding matters nor saturated.
bool is_measurable(const Patch& patch) {
  constexpr float kDarkest = 16, kBrightest = 235;  // levels
  return std::all_of(std::begin(patch.mean), std::end(patch.mean),
                     [](float mean) { return mean > kDarkest && mean < kBrightest; });
}

/// Where point i of the cloud is at a time, as far as its own time and velocity are known.
glm::dvec3 point_at(const PointCloud& cloud, size_t i, double time) {
  const glm::dvec3 point(cloud.position[i]);
  if (cloud.velocity.empty() || cloud.time.empty() || !std::isfinite(cloud.time[i])) return point;
  return point + (time - double(cloud.time[i])) * glm::dvec3(cloud.velocity[i]);
}

/// Colours of a point of the cloud: every other camera against the one whose patch most others
/// resemble.
void add_pairs(size_t point, const Scene& scene, const std::vector<int>& frames,
               const std::map<std::string, int>& index, std::vector<ColourPair>& pairs) {
  constexpr float kLeastTexture = 2, kMostDifference = 12, kMostUnlike = 0.7f;  // as plane_sweep
  struct Seen {
    int camera;
    Patch patch;
  };
  std::vector<Seen> seen;
  for (int i : frames) {
    const Frame& frame = scene.frames[size_t(i)];
    const std::optional<Patch> patch = patch_of(frame, point_at(scene.points, point, frame.time));
    if (patch && is_measurable(*patch) && texture(*patch) >= kLeastTexture)
      seen.push_back({index.at(frame.camera_name), *patch});
  }
  const auto agree = [&](const Patch& a, const Patch& b) {
    return difference(a, b) < std::min(kMostDifference, kMostUnlike * texture(a));
  };
  size_t best = 0, most = 0;
  for (size_t i = 0; i < seen.size(); ++i) {
    const auto alike = size_t(std::count_if(seen.begin(), seen.end(), [&](const Seen& other) {
      return agree(seen[i].patch, other.patch);
    }));
    if (alike > most) {
      most = alike;
      best = i;
    }
  }
  for (size_t i = 0; i < seen.size(); ++i) {
    const Patch &a = seen[best].patch, &b = seen[i].patch;
    if (i == best || !agree(a, b)) continue;
    pairs.push_back({seen[best].camera, seen[i].camera, {}, {}});
    for (size_t c = 0; c < 3; ++c) {
      pairs.back().colour_a[c] = a.mean[c];
      pairs.back().colour_b[c] = b.mean[c];
    }
  }
}

}  // namespace

std::vector<CameraGain> fit_gains(const std::vector<std::string>& cameras,
                                  const std::vector<ColourPair>& pairs) {
  std::vector<CameraGain> gains;
  for (const std::string& camera : cameras) gains.push_back({camera, {1, 1, 1}, 0});
  for (const ColourPair& pair : pairs) {
    ++gains[size_t(pair.a)].pairs;
    ++gains[size_t(pair.b)].pairs;
  }
  const auto is_known = [&](int camera) {
    return gains[size_t(camera)].pairs >= kLeastColourPairs;
  };
  for (size_t k = 0; k < 3; ++k) {
    std::vector<LogRatio> ratios;
    for (const ColourPair& pair : pairs)
      if (pair.colour_a[k] > 0 && pair.colour_b[k] > 0 && is_known(pair.a) && is_known(pair.b))
        ratios.push_back(
            {size_t(pair.a), size_t(pair.b), std::log(pair.colour_a[k] / pair.colour_b[k])});
    if (ratios.empty()) continue;
    const std::vector<double> logs = log_gains(ratios, cameras.size());
    double sum = 0, count = 0;
    for (size_t c = 0; c < cameras.size(); ++c)
      if (is_known(int(c))) {
        sum += std::exp(logs[c]);
        ++count;
      }
    for (size_t c = 0; c < cameras.size(); ++c)
      if (is_known(int(c))) gains[c].gain[k] = std::exp(logs[c]) * count / sum;
  }
  return gains;
}

std::vector<CameraGain> measured_gains(const Scene& scene) {
  constexpr size_t kPoints = 4000;
  const std::vector<Timestep> timesteps = training_timesteps(scene);
  std::map<std::string, int> index;
  for (int i : scene.split_indices(Split::kTrain))
    index.emplace(scene.frames[size_t(i)].camera_name, 0);
  std::vector<std::string> cameras;
  for (auto& [name, place] : index) {
    place = int(cameras.size());
    cameras.push_back(name);
  }
  const PointCloud& cloud = scene.points;
  const size_t count = std::min(kPoints, cloud.position.size());
  std::vector<ColourPair> pairs;
  for (size_t k = 0; k < count && !timesteps.empty(); ++k) {
    const size_t i = k * cloud.position.size() / count;
    // when it was seen, else the timesteps in turn
    const bool is_timed = !cloud.time.empty() && std::isfinite(cloud.time[i]);
    const auto nearest = [&](const Timestep& a, const Timestep& b) {
      return std::abs(a.time - double(cloud.time[i])) < std::abs(b.time - double(cloud.time[i]));
    };
    const Timestep& timestep = is_timed
                                   ? *std::min_element(timesteps.begin(), timesteps.end(), nearest)
                                   : timesteps[k % timesteps.size()];
    if (timestep.frames.size() > 1) add_pairs(i, scene, timestep.frames, index, pairs);
  }
  return fit_gains(cameras, pairs);
}

double largest_difference(const std::vector<CameraGain>& gains) {
  double largest = 0;
  for (const CameraGain& camera : gains)
    for (const double gain : camera.gain)
      if (camera.pairs >= kLeastColourPairs) largest = std::max(largest, std::abs(gain - 1));
  return largest;
}

}  // namespace tessera
