// Chooses the rig, the lens, the number of frames and the timesteps; camera_path.h has the curves.
#include "tools/camera_paths/path_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "kernels/base/errors.h"
#include "static3d/transform/scene_box.h"
#include "tools/camera_paths/camera_path.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char *kOrbit = "orbit", *kSpiral = "spiral";
constexpr double kShortest = 6, kLongest = 60;  // seconds of a video by default
constexpr double kMostFrames = 100000;
constexpr int kSmallest = 16, kLargest = 8192;                // pixels
constexpr int kWidth = 1280, kHeight = 720;                   // without any camera
constexpr double kFieldOfView = 50 * std::numbers::pi / 180;  // vertical, likewise
constexpr int64_t kMostPoints = 20000;                        // of a model, to find its depth

bool has_key_frames(const PathChoice& choice) {
  return choice.path != kOrbit && choice.path != kSpiral;
}

struct Size {
  int width = 0, height = 0;
};

Size parse_size(const PathChoice& choice) {
  Size size;
  const std::string& text = choice.size;
  const char* const end = text.data() + text.size();
  auto parsed = std::from_chars(text.data(), end, size.width);
  if (parsed.ec == std::errc() && parsed.ptr != end && *parsed.ptr == 'x')
    parsed = std::from_chars(parsed.ptr + 1, end, size.height);
  const auto [low, high] = std::minmax(size.width, size.height);
  if (parsed.ec != std::errc() || parsed.ptr != end || low < kSmallest || high > kLargest)
    throw InputError(
        fmt::format("render: --size is '{}'; give width and height, {} to {}, as in "
                    "1280x720",
                    text, kSmallest, kLargest));
  if (choice.for_video && (size.width % 2 != 0 || size.height % 2 != 0))
    throw InputError(fmt::format(
        "render: --size {} is odd, which 4:2:0 video cannot hold; give {}x{} or leave --mp4 out",
        text, size.width / 2 * 2, size.height / 2 * 2));
  return size;
}

/// The camera in the requested size, else in its original one, made even for a video.
Camera lens_of(const PathChoice& choice, const Camera& camera) {
  Size size{camera.width, camera.height};
  if (!choice.size.empty()) {
    size = parse_size(choice);
  } else if (choice.for_video) {
    size = {std::max(2, size.width / 2 * 2), std::max(2, size.height / 2 * 2)};
  }
  return with_size(camera, size.width, size.height);
}

/// Means of both sets, at most about kMostPoints of them.
PointCloud points_of(const GaussianModel& model) {
  PointCloud points;
  const int64_t step = 1 + model.count() / kMostPoints;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    for (int64_t n = 0; n < set->count(); n += step) {
      const float* const mean = set->values().at(kMean, n);
      const glm::vec3 point(mean[0], mean[1], mean[2]);
      if (std::isfinite(point.x + point.y + point.z)) points.position.push_back(point);
    }
  return points;
}

std::vector<Camera> rig_of(const PathChoice& choice, const DrawnModel& drawn) {
  CameraChoice rig{choice.cameras, choice.split, 0.0};  // timesteps are not needed
  if (rig.cameras.empty()) {
    rig.cameras = scene_of_model(drawn.named);
    if (rig.cameras.empty()) return {};
  }
  std::vector<Camera> cameras;
  for (const NamedView& named : read_views(rig, drawn.model)) cameras.push_back(named.view.camera);
  return cameras;
}

Camera lens_without_rig() {
  Camera lens;
  lens.width = kWidth;
  lens.height = kHeight;
  lens.fl_x = lens.fl_y = 0.5 * kHeight / std::tan(0.5 * kFieldOfView);
  lens.cx = 0.5 * kWidth;
  lens.cy = 0.5 * kHeight;
  return lens;
}

std::vector<Camera> orbit_without_rig(const PathChoice& choice, const DrawnModel& drawn,
                                      int64_t count) {
  const SceneBox box = scene_box(drawn.model);
  const glm::dvec3 up = drawn.is_splats ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
  const Camera lens = lens_of(choice, lens_without_rig());
  const glm::dvec3 centre(box.centre[0], box.centre[1], box.centre[2]);
  return orbit_path(orbit_of_box(centre, box.half_extent, up, lens), lens, count);
}

std::vector<Camera> curve(const PathChoice& choice, const DrawnModel& drawn, int64_t count,
                          std::vector<std::string>& warnings) {
  const std::vector<Camera> rig = rig_of(choice, drawn);
  const bool orbit = choice.path == kOrbit;
  if (rig.empty() && orbit) return orbit_without_rig(choice, drawn, count);
  if (rig.empty())
    throw InputError(
        fmt::format("{}: --path spiral needs a rig; pass --cameras SCENE or take --path orbit",
                    drawn.named.string()));
  const PointCloud points = points_of(drawn.model);
  const Camera lens = lens_of(choice, rig.front());
  if (!orbit) return spiral_path(rig, points, lens, count);
  const OrbitFrame frame = orbit_of_rig(rig, points);
  if (looks_one_way(rig, frame.up))
    warnings.push_back(
        "the rig looks one way; --path orbit shows what no camera saw: use --path spiral");
  return orbit_path(frame, lens, count);
}

bool plays(const PathChoice& choice, const GaussianModel& model) {
  return !choice.time && model.moves();
}

double rate_of(const PathChoice& choice) {
  const double rate = choice.rate.value_or(1);
  if (!(rate > 0) || !std::isfinite(rate))
    throw InputError(fmt::format(
        "render: --rate is {}, expected more than 0; pass --time for a still clip", rate));
  return rate;
}

int64_t frame_count(const PathChoice& choice, double seconds) {
  const double frames = std::round(seconds * choice.fps.value());
  if (!(seconds > 0) || !(frames <= kMostFrames))
    throw InputError(
        fmt::format("render: {} s at {}/{} frames a second make {} frames, expected 1 to {}; pass "
                    "other --seconds or --fps",
                    seconds, choice.fps.numerator, choice.fps.denominator, frames, kMostFrames));
  return std::max<int64_t>(1, int64_t(frames));
}

/// Whole rounds of the clip, so that the video can be looped.
double default_seconds(const PathChoice& choice, const GaussianModel& model) {
  if (!plays(choice, model)) return kShortest;
  const double round = model.time_axis.duration / rate_of(choice);
  return std::min(kLongest, std::ceil(kShortest / round) * round);
}

/// The clip's timestep when frame i is shown.
double played_time(const PathChoice& choice, const GaussianModel& model, int64_t i) {
  if (!plays(choice, model)) return choice.time.value_or(0);
  constexpr double kRounding =
      1e-9;  // of a round: what rounding puts just before the first timestep
  const double rounds =
      double(i) / choice.fps.value() * rate_of(choice) / model.time_axis.duration + kRounding;
  return std::max(0.0, rounds - std::floor(rounds) - kRounding);
}

std::vector<View> views_through_keys(const PathChoice& choice, const DrawnModel& drawn) {
  const std::vector<KeyFrame> keys = read_key_frames(choice.path, choice.split, drawn.model);
  if (keys.empty())
    throw InputError(fmt::format("{}: no frame in split '{}'; choose another of train, val, test",
                                 choice.path, choice.split));
  std::vector<Camera> cameras;
  const Camera first = lens_of(choice, keys.front().camera);
  for (const KeyFrame& key : keys)
    cameras.push_back(with_size(key.camera, first.width, first.height));
  const int64_t count =
      choice.seconds ? frame_count(choice, *choice.seconds) : int64_t(keys.size());
  const std::vector<Camera> path = key_path(cameras, count);
  const bool stated = plays(choice, drawn.model) && !choice.rate && keys.front().time;
  std::vector<View> views;
  for (int64_t i = 0; i < count; ++i) {
    const auto [key, share] = key_place(i, count, int64_t(keys.size()));
    const KeyFrame &a = keys[size_t(key)], &b = keys[size_t(key) + (share > 0 ? 1 : 0)];
    const double time =
        stated ? *a.time + share * (*b.time - *a.time) : played_time(choice, drawn.model, i);
    views.push_back({path[size_t(i)], time});
  }
  return views;
}

}  // namespace

void check_path_choice(const PathChoice& choice) {
  if (has_key_frames(choice) && !fs::is_regular_file(choice.path))
    throw InputError(fmt::format(
        "render: --path '{}' is {}; expected orbit, spiral or a transforms file of key frames",
        choice.path, fs::is_directory(choice.path) ? "a folder" : "no file"));
  rate_of(choice);
  if (!choice.size.empty()) parse_size(choice);
  if (choice.seconds) frame_count(choice, *choice.seconds);
  if (has_key_frames(choice) && !choice.cameras.empty())
    throw InputError(
        fmt::format("render: --path {} has its own cameras; leave --cameras out", choice.path));
}

std::vector<NamedView> path_views(const PathChoice& choice, const DrawnModel& drawn,
                                  std::vector<std::string>& warnings) {
  check_path_choice(choice);
  std::vector<View> views;
  if (!has_key_frames(choice)) {
    const double seconds = choice.seconds.value_or(default_seconds(choice, drawn.model));
    for (const Camera& camera : curve(choice, drawn, frame_count(choice, seconds), warnings))
      views.push_back({camera, played_time(choice, drawn.model, int64_t(views.size()))});
  } else {
    views = views_through_keys(choice, drawn);
  }
  const size_t digits = std::max<size_t>(4, std::to_string(views.size() - 1).size());
  std::vector<NamedView> named;
  for (const View& view : views)
    named.push_back({fmt::format("frame_{:0{}}", named.size(), digits), view});
  return named;
}

}  // namespace tessera
