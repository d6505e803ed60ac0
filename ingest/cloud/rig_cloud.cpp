// What: which timesteps are loaded when, and the seconds that both halves take.
// Not: depths (plane_sweep.h) or displacements (point_velocities.h).
#include "ingest/cloud/rig_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "ingest/clocks/training_timesteps.h"
#include "ingest/layouts/scene_reader.h"

namespace tessera {
namespace {

constexpr size_t kFewestCameras = 3;  // that a depth is agreed on by

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Scene load(const std::filesystem::path& folder,
           std::optional<std::vector<int64_t>> timesteps = std::nullopt) {
  SceneOptions options;
  options.allow_static = true;
  options.load_pixels = timesteps.has_value();
  options.timesteps = std::move(timesteps);
  return load_scene(folder, options);
}

/// Timesteps whose training images fit into the memory that the sweep may take.
int64_t timesteps_in_memory(const Scene& scene, const std::vector<Timestep>& timesteps) {
  constexpr int64_t kBytes = int64_t{2} << 30, kFewest = 2;
  int64_t largest = 1;
  for (const Timestep& timestep : timesteps) {
    int64_t bytes = 0;
    for (int i : timestep.frames) {
      const Camera& camera = scene.frames[size_t(i)].camera;
      bytes += int64_t{3} * camera.width * camera.height;
    }
    largest = std::max(largest, bytes);
  }
  return std::max(kBytes / largest, kFewest);
}

/// The numbers before and after, as far as there are any.
std::vector<int64_t> beside(int64_t number, int64_t count) {
  std::vector<int64_t> numbers;
  if (number > 0) numbers.push_back(number - 1);
  if (number + 1 < count) numbers.push_back(number + 1);
  return numbers;
}

/// A scene on disk by its timesteps.
class Clip {
 public:
  explicit Clip(const std::filesystem::path& folder)
      : folder_(folder), listed_(load(folder)), timesteps_(training_timesteps(listed_)) {}
  bool has_rig() const {
    return std::any_of(timesteps_.begin(), timesteps_.end(), [](const Timestep& timestep) {
      return timestep.frames.size() >= kFewestCameras;
    });
  }
  std::vector<int64_t> keys() const {
    return key_timesteps(int64_t(timesteps_.size()), timesteps_in_memory(listed_, timesteps_));
  }
  Scene loaded(const std::vector<int64_t>& numbers) const { return load(folder_, numbers); }
  /// Velocities of those of `points` whose frames belong to the timestep of that number.
  VelocityCount find_velocities_at(int64_t number, const PlaneSweep& sweep,
                                   std::vector<SweptPoint>& points) const {
    std::set<std::string> names;
    for (int i : timesteps_[size_t(number)].frames) names.insert(listed_.frames[size_t(i)].name);
    std::vector<SweptPoint*> found;
    for (SweptPoint& point : points)
      if (names.contains(sweep.scene().frames[size_t(point.frame)].name)) found.push_back(&point);
    const std::vector<int64_t> around = beside(number, int64_t(timesteps_.size()));
    return around.empty() ? VelocityCount{} : find_velocities(sweep, loaded(around), found);
  }

 private:
  std::filesystem::path folder_;
  Scene listed_;  // without pixels
  std::vector<Timestep> timesteps_;
};

}  // namespace

RigCloud rig_cloud(const std::filesystem::path& folder, const CloudOptions& options) {
  RigCloud cloud;
  const Clip clip(folder);
  if (!clip.has_rig()) return cloud;
  const std::vector<int64_t> keys = clip.keys();
  cloud.key_timesteps = int64_t(keys.size());
  Clock::time_point start = Clock::now();
  const Scene scene = clip.loaded(keys);
  const PlaneSweep sweep(scene);
  std::vector<SweptPoint> points = dense_points(sweep, options);
  cloud.sweep_seconds = seconds_since(start);
  start = Clock::now();
  for (int64_t key : keys) {
    if (options.progress) options.progress(int64_t(points.size()));
    const VelocityCount count = clip.find_velocities_at(key, sweep, points);
    cloud.velocities.moving += count.moving;
    cloud.velocities.reliable += count.reliable;
  }
  cloud.velocity_seconds = seconds_since(start);
  cloud.points = cloud_of(points);
  return cloud;
}

std::string summary(const RigCloud& cloud) {
  return fmt::format(
      "plane sweep: {} points at {} key timesteps in {:.1f} s; {} of them move, and {} of these "
      "have a velocity, found in {:.1f} s",
      cloud.points.position.size(), cloud.key_timesteps, cloud.sweep_seconds,
      cloud.velocities.moving, cloud.velocities.reliable, cloud.velocity_seconds);
}

}  // namespace tessera
