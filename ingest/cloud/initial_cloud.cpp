// Runs the plane sweep where the capture is a rig, with few timesteps in memory at a time.
#include "ingest/cloud/initial_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "ingest/clocks/timesteps.h"
#include "ingest/files/point_cloud.h"
#include "kernels/base/seconds_since.h"

namespace tessera {
namespace {

constexpr int64_t kFewestCameras = 3;  // that a depth is agreed on by

using Clock = std::chrono::steady_clock;

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

/// The training timesteps at which half of the cameras that film together do so, or more: where
/// clocks differ by frames, fewer have the first and the last ones.
std::vector<Timestep> shared_timesteps(const Scene& scene) {
  std::vector<Timestep> timesteps = training_timesteps(scene);
  size_t most = 0;
  for (const Timestep& timestep : timesteps) most = std::max(most, timestep.frames.size());
  std::erase_if(timesteps,
                [&](const Timestep& timestep) { return 2 * timestep.frames.size() < most; });
  return timesteps;
}

/// The frames of a clip by its shared timesteps, which count from 0 here.
class Clip {
 public:
  explicit Clip(const CloudFrames& frames)
      : frames_(frames), timesteps_(shared_timesteps(frames.listed())) {}
  bool has_rig() const {
    return std::any_of(timesteps_.begin(), timesteps_.end(), [](const Timestep& timestep) {
      return int64_t(timestep.frames.size()) >= kFewestCameras;
    });
  }
  std::vector<int64_t> keys() const {
    return key_timesteps(count(), timesteps_in_memory(frames_.listed(), timesteps_));
  }
  /// The frames of these timesteps.
  Scene loaded(const std::vector<int64_t>& places) const {
    std::vector<int64_t> numbers;
    for (const int64_t place : places) numbers.push_back(timesteps_.at(size_t(place)).number);
    return frames_.at(numbers);
  }
  int64_t count() const { return int64_t(timesteps_.size()); }

 private:
  const CloudFrames& frames_;
  std::vector<Timestep> timesteps_;
};

/// A timestep and those beside it, each loaded once while the timesteps ascend.
class Neighbours {
 public:
  explicit Neighbours(const Clip& clip) : clip_(clip) {}
  void move_to(int64_t place) {
    place_ = place;
    std::erase_if(scenes_, [&](const auto& scene) { return scene.first < place - 1; });
    for (int64_t i = std::max<int64_t>(place - 1, 0); i <= place + 1 && i < clip_.count(); ++i)
      if (!scenes_.contains(i)) scenes_.emplace(i, clip_.loaded({i}));
  }
  const Scene& here() const { return scenes_.at(place_); }
  /// Those before and after, as far as there are any.
  std::vector<const Scene*> beside() const {
    std::vector<const Scene*> scenes;
    for (const auto& [place, scene] : scenes_)
      if (place != place_) scenes.push_back(&scene);
    return scenes;
  }

 private:
  const Clip& clip_;
  int64_t place_ = 0;
  std::map<int64_t, Scene> scenes_;
};

/// What moves at a timestep, with velocities.
class MovingPoints {
 public:
  MovingPoints(const Clip& clip, const CloudOptions& options,
               std::shared_ptr<const StillPixels> still_pixels, PixelSearch* device,
               RigCloud& cloud)
      : window_(clip),
        options_(options),
        still_pixels_(std::move(still_pixels)),
        device_(device),
        cloud_(cloud) {
    options_.part = CloudPart::kMoving;
    options_.progress = nullptr;
  }
  /// `place`: greater than that of the call before.
  std::vector<SweptPoint> at(int64_t place, int64_t most) {
    options_.points = most;
    options_.seed += 1;
    const Clock::time_point start = Clock::now();
    window_.move_to(place);
    PlaneSweep sweep(window_.here(), still_pixels_, device_);
    cloud_.sweep_seconds += seconds_since(start);
    VelocityCount count;
    std::vector<SweptPoint> points = found(sweep, count);
    // where clocks differ, more of what moves is found once it is known how some of it does
    constexpr int kRounds = 2;
    for (int round = 0; round < kRounds && sweep.expect_motion_of(points); ++round)
      points = found(sweep, count);
    cloud_.velocities.moving += count.moving;
    cloud_.velocities.reliable += count.reliable;
    return points;
  }

 private:
  std::vector<SweptPoint> found(const PlaneSweep& sweep, VelocityCount& count) {
    count = {};
    Clock::time_point start = Clock::now();
    std::vector<SweptPoint> points = dense_points(sweep, options_);
    cloud_.sweep_seconds += seconds_since(start);
    start = Clock::now();
    const std::vector<const Scene*> beside = window_.beside();
    if (!points.empty() && !beside.empty()) {
      std::vector<SweptPoint*> all;
      for (SweptPoint& point : points) all.push_back(&point);
      count = find_velocities(sweep, beside, all);
    }
    cloud_.velocity_seconds += seconds_since(start);
    return points;
  }

  Neighbours window_;
  CloudOptions options_;
  std::shared_ptr<const StillPixels> still_pixels_;
  PixelSearch* device_;
  RigCloud& cloud_;
};

/// Cameras of the training split that share the scene's fullest timestep; 1 for monocular captures.
int64_t cameras_of_a_timestep(const Capture& scene) {
  std::vector<FrameTime> times;
  for (const CaptureFrame& prepared : scene.frames)
    times.push_back({prepared.frame.camera_name, prepared.frame.time, prepared.frame.split});
  const std::vector<int64_t> numbers = timestep_numbers(times);
  std::map<int64_t, std::set<std::string>> cameras;  // of each timestep
  for (size_t i = 0; i < numbers.size(); ++i)
    if (times[i].split == Split::kTrain) cameras[numbers[i]].insert(times[i].camera);
  size_t most = 0;
  for (const auto& [number, names] : cameras) most = std::max(most, names.size());
  return int64_t(most);
}

/// Whether the points of a photo set are those of its COLMAP model.
bool has_model(const Capture& capture) {
  return !capture.photos.empty() && !capture.points_file;
}

/// Dense by itself for rigs; photo sets have their COLMAP points, and far too many images a
/// timestep. A cloud that says what stands still is dense already. Where frames stay in their
/// videos, single timesteps cost much to read, and a training makes the cloud of the frames that it
/// loads.
CloudDensity density(const Capture& capture, const IngestOptions& options) {
  if (!capture.points.still.empty() && options.cloud != CloudDensity::kNone)
    return CloudDensity::kSparse;
  if (options.cloud) return *options.cloud;
  if (has_model(capture) || cameras_of_a_timestep(capture) < kFewestCameras)
    return CloudDensity::kSparse;
  return capture.by_reference ? CloudDensity::kNone : CloudDensity::kDense;
}

/// Of the pixels of all frames of a sweep, those that look different at other timesteps.
double changing_share(const PlaneSweep& sweep) {
  constexpr int kApart = 7;  // pixels
  int64_t changing = 0, all = 0;
  for (const int frame : sweep.frames()) {
    const Image8& image = sweep.scene().frames[size_t(frame)].image;
    for (int y = 0; y < image.height; y += kApart)
      for (int x = 0; x < image.width; x += kApart) {
        changing += sweep.moves({frame, x, y});
        ++all;
      }
  }
  return all > 0 ? double(changing) / double(all) : 0;
}

}  // namespace

RigCloud rig_cloud(const CloudFrames& frames, const CloudOptions& options,
                   const std::function<std::unique_ptr<PixelSearch>()>& device) {
  RigCloud cloud;
  const Clip clip(frames);
  if (!clip.has_rig()) return cloud;
  const std::unique_ptr<PixelSearch> search = device ? device() : nullptr;
  const std::vector<int64_t> keys = clip.keys(), motion_keys = motion_timesteps(clip.count());
  cloud.key_timesteps = int64_t(keys.size());
  cloud.motion_timesteps = int64_t(motion_keys.size());
  Clock::time_point start = Clock::now();
  const Scene scene = clip.loaded(keys);
  const auto still_pixels = std::make_shared<const StillPixels>(scene);
  cloud.sweep_seconds = seconds_since(start);
  MovingPoints moving(clip, options, still_pixels, search.get(), cloud);
  const auto count = int64_t(motion_keys.size());
  const int64_t most = options.points / 2;
  std::vector<SweptPoint> points;
  for (int64_t i = 0; i < count; ++i) {
    if (options.progress) options.progress(int64_t(points.size()));
    const std::vector<SweptPoint> found =
        moving.at(motion_keys[size_t(i)], most * (i + 1) / count - most * i / count);
    points.insert(points.end(), found.begin(), found.end());
  }
  start = Clock::now();
  CloudOptions still = options;
  still.part = CloudPart::kStill;
  still.points = options.points - int64_t(points.size());
  if (options.progress)
    still.progress = [&](int64_t done) { options.progress(int64_t(points.size()) + done); };
  const PlaneSweep sweep(scene, still_pixels, search.get());
  const std::vector<SweptPoint> found = dense_points(sweep, still);
  if (cloud.velocities.moving == 0) cloud.changing_share = changing_share(sweep);
  points.insert(points.end(), found.begin(), found.end());
  cloud.sweep_seconds += seconds_since(start);
  cloud.points = cloud_of(points);
  return cloud;
}

std::string summary(const RigCloud& cloud) {
  return fmt::format(
      "plane sweep: {} points in {:.1f} s, of static things at {} timesteps and of moving ones "
      "at {}; {} points move, and {} of these have a velocity, found in {:.1f} s",
      cloud.points.position.size(), cloud.sweep_seconds, cloud.key_timesteps,
      cloud.motion_timesteps, cloud.velocities.moving, cloud.velocities.reliable,
      cloud.velocity_seconds);
}

std::string motion_warning(const RigCloud& cloud) {
  constexpr double kChanges = 0.01;
  if (cloud.points.position.empty() || cloud.velocities.moving > 0 ||
      cloud.changing_share < kChanges)
    return "";
  return fmt::format(
      "{:.0f} % of the pixels change over time, and no point that moves was found: check the "
      "clocks of the cameras (--sync, --offsets) and their poses; what moves starts without points",
      100 * cloud.changing_share);
}

void add_initial_cloud(const std::filesystem::path& folder, const IngestOptions& options,
                       const IngestProgress& progress, Capture& capture) {
  const CloudDensity wanted = density(capture, options);
  if (wanted == CloudDensity::kNone) capture.points = {};
  if (wanted != CloudDensity::kDense) return;
  CloudOptions cloud;
  cloud.points = options.cloud_points;
  cloud.progress = [&](int64_t done) { progress("initial cloud", done, options.cloud_points); };
  cloud.progress(0);
  const RigCloud found = rig_cloud(FolderFrames(folder), cloud, options.pixel_search);
  if (found.points.position.empty())
    capture.warnings.push_back(
        fmt::format("no dense cloud: {}; the training starts from {}",
                    cameras_of_a_timestep(capture) < kFewestCameras
                        ? "no three training cameras show the same timestep"
                        : "the cameras agree on the depth of no pixel, check their poses",
                    capture.points.position.empty() ? "random points" : "the sparse points"));
  else
    capture.notes.push_back(summary(found));
  if (const std::string warning = motion_warning(found); !warning.empty())
    capture.warnings.push_back(warning);
  progress("initial cloud", options.cloud_points, options.cloud_points);
  add_points(capture.points, found.points);
}

std::optional<int64_t> cameras_of_a_rig(const Capture& capture) {
  const int64_t cameras = cameras_of_a_timestep(capture);
  const bool monocular = capture.layout == "transforms" ? cameras < 2 : capture.cameras.size() < 2;
  return has_model(capture) || monocular ? std::nullopt : std::optional(cameras);
}

}  // namespace tessera
