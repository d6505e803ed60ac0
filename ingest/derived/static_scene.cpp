// One camera after another, so that the frames of one alone are in memory.
#include "ingest/derived/static_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/derived/camera_background.h"
#include "ingest/derived/derived_scene.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int64_t kQuarters = 4;
constexpr int64_t kLeastMoments = 3;
constexpr double kLeastShared = 0.5;  // of the pixels, below which there is a warning

struct StillImage {
  Frame frame;                   // with image and mask
  int64_t used = 0, shared = 0;  // pixels that the scene's mask uses, and those of them that stay
};

/// Places of each camera's frames in the scene, in the order of the cameras' first frames, each in
/// the order of time.
std::vector<std::vector<int>> frames_by_camera(const Scene& scene) {
  std::vector<std::vector<int>> cameras;
  std::map<std::string, size_t> known;
  for (int i = 0; i < int(scene.frames.size()); ++i) {
    const auto [camera, is_new] =
        known.try_emplace(scene.frames[size_t(i)].camera_name, cameras.size());
    if (is_new) cameras.emplace_back();
    cameras[camera->second].push_back(i);
  }
  for (std::vector<int>& frames : cameras)
    std::stable_sort(frames.begin(), frames.end(), [&](int a, int b) {
      return scene.frames[size_t(a)].time < scene.frames[size_t(b)].time;
    });
  return cameras;
}

void check_camera(const Scene& scene, const std::vector<int>& frames) {
  const Frame& first = scene.frames[size_t(frames.front())];
  for (const int i : frames)
    if (!(scene.frames[size_t(i)].camera == first.camera))
      throw InputError(fmt::format(
          "{}: camera {} moves, so that nothing stands still in its images; only a rig of fixed "
          "cameras has a shared background",
          scene.path, first.camera_name));
  if (int64_t(frames.size()) < kQuarters * kLeastMoments)
    throw InputError(fmt::format(
        "{}: camera {} has {} frames, and a background needs {} to be told from what moves; train "
        "the clip as a whole",
        scene.path, first.camera_name, frames.size(), kQuarters * kLeastMoments));
}

/// Frames of a quarter, one of each of its equal parts, in each at another place: at equal
/// distances what moves to and fro in that time would look the same in all of them.
std::vector<int> moments_of(const std::vector<int>& frames, int64_t quarter) {
  constexpr double kGoldenRatio = 0.6180339887498949;
  const auto total = int64_t(frames.size());
  const int64_t begin = quarter * total / kQuarters, end = (quarter + 1) * total / kQuarters,
                count = std::min(kMostOfQuarter, end - begin);
  std::vector<int> chosen;
  for (int64_t i = 0; i < count; ++i) {
    const double within = double(i) * kGoldenRatio - std::floor(double(i) * kGoldenRatio);
    const double place = (double(i) + within) * double(end - begin) / double(count);
    chosen.push_back(frames[size_t(begin + int64_t(place))]);
  }
  return chosen;
}

StillImage still_image(const SceneFiles& files, const std::vector<int>& frames) {
  CameraBackground background;
  StillImage still;
  for (int64_t quarter = 0; quarter < kQuarters; ++quarter) {
    SceneOptions options;
    options.allow_static = true;
    options.frames = moments_of(frames, quarter);
    Scene scene = files.load(options);
    if (scene.had_alpha)
      throw InputError(
          fmt::format("{}: images have alpha, so that their background is known and none is shared",
                      scene.path));
    CameraBackground::Images images, masks;
    for (const Frame& frame : scene.frames) {
      images.push_back(&frame.image.data);
      masks.push_back(&frame.mask.data());
    }
    background.add_quarter(images, masks);
    if (quarter == 0) still.frame = std::move(scene.frames.front());
  }
  Image8& image = still.frame.image;
  image.data = background.image();
  Image8 mask{image.width, image.height, 1, {}};
  for (size_t p = 0; p < image.data.size() / 3; ++p) {
    const bool is_shared = background.stays(p);
    mask.data.push_back(is_shared ? 255 : 0);
    still.used += background.is_used(p);
    still.shared += is_shared;
  }
  still.frame.mask = std::move(mask);
  still.frame.time = 0;
  return still;
}

/// Whether the mask of some camera that sees a point uses the pixel that shows it.
bool is_shown(const glm::dvec3& point, const std::vector<Frame>& frames) {
  return std::any_of(frames.begin(), frames.end(), [&](const Frame& frame) {
    const Camera& camera = frame.camera;
    const glm::dvec3 seen = camera.cam_from_world * point + camera.translation;
    if (!(seen.z > 0)) return false;
    const double x = camera.fl_x * seen.x / seen.z + camera.cx,
                 y = camera.fl_y * seen.y / seen.z + camera.cy;
    return x >= 0 && y >= 0 && x < camera.width && y < camera.height &&
           !frame.mask.ignores(int(x), int(y));
  });
}

PointCloud still_points(const PointCloud& points, const std::vector<Frame>& frames) {
  PointCloud kept;
  for (size_t i = 0; i < points.position.size(); ++i) {
    if (!points.still.empty() && points.still[i] == 0) continue;
    if (!is_shown(glm::dvec3(points.position[i]), frames)) continue;
    kept.position.push_back(points.position[i]);
    kept.colour.push_back(points.colour[i]);
  }
  if (!points.still.empty()) kept.still.assign(kept.position.size(), 1);
  return kept;
}

}  // namespace

StaticSceneReport write_static_scene(const fs::path& folder, const fs::path& out,
                                     const std::function<void(int64_t, int64_t)>& progress) {
  check_is_prepared(folder);
  const SceneFiles files(folder, true);
  SceneOptions options;
  options.allow_static = true;
  options.load_pixels = false;
  Scene scene = files.load(options);
  const std::vector<std::vector<int>> cameras = frames_by_camera(scene);
  for (const std::vector<int>& frames : cameras) check_camera(scene, frames);
  const int64_t timesteps = scene.timesteps_of(Split::kTrain);
  StagedFolder staged(out, is_prepared_scene(out), files_of_scene(out));
  const ordered_json source = ordered_json::parse(read_text_file(folder / "transforms.json"));
  const FrameEntries entries(source);
  std::vector<Frame> stills;
  std::vector<ordered_json> listed;
  StaticSceneReport report;
  int64_t used = 0, shared = 0;
  for (const std::vector<int>& frames : cameras) {
    StillImage still = still_image(files, frames);
    used += still.used;
    shared += still.shared;
    Frame& frame = still.frame;
    ordered_json entry = entries.image_entry(frame);
    entry["mask_path"] = "masks/" + frame.name + ".png";
    write_png(staged.path() / (frame.name + ".png"), frame.image);
    write_png(staged.path() / entry["mask_path"].get<std::string>(), frame.mask.image());
    listed.push_back(std::move(entry));
    frame.image.data.clear();
    stills.push_back(std::move(frame));
    progress(++report.cameras, int64_t(cameras.size()));
  }
  report.shared = used > 0 ? double(shared) / double(used) : 0;
  if (report.shared < kLeastShared)
    report.warnings.push_back(fmt::format(
        "{}: only {:.0f} % of the pixels look the same all along: its light or "
        "most of what it shows changes, and a shared background saves little; training the clip "
        "without one costs nothing else",
        folder.string(), 100 * report.shared));
  scene.points = still_points(scene.points, stills);
  scene.is_static = true;
  scene.time_axis = {scene.time_axis.origin, 1};
  if (!scene.points.position.empty()) write_points(staged.path() / "points.ply", scene.points);
  ordered_json file = description_of(source, scene);
  for (ordered_json& entry : listed) file["frames"].push_back(std::move(entry));
  file["tessera"]["applied"]["masks"] = "black ignored";
  file["tessera"]["time"]["static_of"] = timesteps;
  write_text_file(staged.path() / "transforms.json", json_text(file, 1) + "\n");
  staged.commit();
  return report;
}

}  // namespace tessera
