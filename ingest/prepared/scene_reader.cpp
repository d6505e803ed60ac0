// Decodes the PNG files in parallel, checks their sizes, normalises times and composites alpha.
#include "ingest/prepared/scene_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <numeric>

#include "ingest/clocks/timesteps.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/poses/far_origin.h"
#include "ingest/poses/world_normalisation.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

bool is_png(const std::filesystem::path& file) {
  return file.extension() == ".png" || file.extension() == ".PNG";
}

void require_png(const std::filesystem::path& file, const std::string& where) {
  if (is_png(file)) return;
  throw InputError(fmt::format(
      "{}: {} is not a PNG; convert the capture with `tessera ingest` and open its result", where,
      file.filename().string()));
}

/// The masks that frames name, each file read once.
class MaskFiles {
 public:
  MaskFiles(const std::vector<TransformsFrame>& frames, bool load_pixels)
      : load_pixels_(load_pixels) {
    for (const TransformsFrame& frame : frames)
      if (!frame.mask.empty()) files_.try_emplace(frame.mask);
  }

  /// Of a frame whose image is width × height; without pixels it has its size only. Threads may
  /// call it at once.
  FrameMask of(const TransformsFrame& listed, int width, int height) {
    if (listed.mask.empty()) return {};
    File& file = files_.at(listed.mask);
    std::call_once(file.read, [&] {
      require_png(listed.mask, listed.where);
      if (load_pixels_)
        file.mask = mask_of_image(read_png(listed.mask), listed.mask);
      else
        file.mask = read_png_size(listed.mask);
    });
    check_mask_size(file.mask.image(), width, height, listed.mask);
    return file.mask;
  }

 private:
  struct File {
    std::once_flag read;
    FrameMask mask;
  };
  const bool load_pixels_;
  std::map<std::filesystem::path, File> files_;
};

/// Decodes and composites one frame, or reads its size only. True when it had alpha.
bool load_frame(const TransformsFrame& listed, const SceneOptions& options, bool with_pixels,
                MaskFiles& masks, Frame& frame) {
  require_png(listed.image, listed.where);
  frame.name = listed.name;
  frame.camera_name = listed.camera_name;
  frame.frame_number = listed.frame_number;
  frame.split = listed.split;
  frame.camera = listed.camera;
  Image8 image = with_pixels ? read_png(listed.image) : read_png_size(listed.image);
  set_intrinsics(frame.camera, listed.intrinsics, image.width, image.height, listed.where);
  frame.mask = masks.of(listed, image.width, image.height);
  const bool had_alpha = image.channels == 4;
  frame.image = {image.width, image.height, 3, {}};
  if (with_pixels)
    frame.image = image.channels == 3 ? std::move(image) : composite_on(image, options.background);
  return had_alpha;
}

/// Numbers of the frames of a split among `chosen`.
std::vector<int> frames_of(const std::vector<TransformsFrame>& frames,
                           const std::vector<int>& chosen, Split split) {
  std::vector<int> found;
  for (const int i : chosen)
    if (frames[size_t(i)].split == split) found.push_back(i);
  return found;
}

std::vector<int> held_out_of(const std::vector<TransformsFrame>& frames,
                             const std::vector<int>& chosen, int64_t count) {
  std::vector<int> all;
  for (Split split : {Split::kTest, Split::kVal, Split::kTrain})
    if (all.empty()) all = frames_of(frames, chosen, split);
  const int64_t number = std::min(count, int64_t(all.size()));
  std::vector<int> kept;
  for (int64_t i = 0; i < number; ++i)
    kept.push_back(all[size_t((2 * i + 1) * int64_t(all.size()) / (2 * number))]);
  return kept;
}

/// Whether all frames of a camera are seen from one place.
bool stands_still(const std::vector<TransformsFrame>& frames, const std::string& camera) {
  const Camera* first = nullptr;
  for (const TransformsFrame& frame : frames) {
    if (frame.camera_name != camera) continue;
    if (first != nullptr && !(frame.camera == *first)) return false;
    first = &frame.camera;
  }
  return true;
}

/// [frames] whether a frame's pixels are loaded.
std::vector<bool> frames_with_pixels(const std::vector<TransformsFrame>& frames,
                                     const SceneOptions& options) {
  std::vector<bool> loaded(frames.size(), options.load_pixels);
  if (!options.load_pixels || !options.pixels_of) return loaded;
  const std::vector<Split>& splits = *options.pixels_of;
  std::map<std::string, bool> whole;  // by name of the camera
  for (size_t i = 0; i < loaded.size(); ++i) {
    const TransformsFrame& frame = frames[i];
    loaded[i] = std::find(splits.begin(), splits.end(), frame.split) != splits.end();
    if (loaded[i] && !whole.contains(frame.camera_name))
      whole[frame.camera_name] = stands_still(frames, frame.camera_name);
  }
  for (size_t i = 0; i < loaded.size(); ++i) {
    const auto camera = whole.find(frames[i].camera_name);
    if (camera != whole.end() && camera->second) loaded[i] = true;
  }
  return loaded;
}

/// The training frames of the timesteps of these numbers, in the order of the timesteps.
std::vector<int> frames_at(const std::vector<TransformsFrame>& frames,
                           const std::vector<int64_t>& timestep, const std::vector<int>& chosen,
                           const std::vector<int64_t>& numbers) {
  const std::vector<int> training = frames_of(frames, chosen, Split::kTrain);
  std::vector<int> kept;
  for (const int64_t number : numbers)
    for (const int i : training)
      if (timestep[size_t(i)] == number) kept.push_back(i);
  return kept;
}

/// All frames in parallel; the error that is reported is the first in file order.
void load_frames(const std::vector<TransformsFrame>& frames, const SceneOptions& options,
                 Scene& scene) {
  const size_t count = frames.size();
  scene.frames.resize(count);
  std::vector<std::string> errors(count);
  std::atomic<bool> had_alpha{false};
  const std::vector<bool> with_pixels = frames_with_pixels(frames, options);
  MaskFiles masks(frames, options.load_pixels);
  parallel_for(int64_t(count), 1, [&](int64_t begin, int64_t end) {
    for (size_t i = size_t(begin); i < size_t(end); ++i) try {
        if (load_frame(frames[i], options, with_pixels[i], masks, scene.frames[i]))
          had_alpha = true;
      } catch (const InputError& error) {
        errors[i] = error.what();
      }
  });
  for (const std::string& error : errors)
    if (!error.empty()) throw InputError(error);
  scene.had_alpha = had_alpha;
}

void check_splits(const Scene& scene) {
  const bool trains = std::any_of(scene.frames.begin(), scene.frames.end(),
                                  [](const Frame& frame) { return frame.split == Split::kTrain; });
  if (!trains)
    throw InputError(
        fmt::format("{}: no frame is in the split 'train'; mark some as training", scene.path));
}

/// Poses and points in a world that can be trained in, whichever frames are loaded. A prepared
/// scene's is.
void place_world(const std::filesystem::path& folder, TransformsCapture& capture, Scene& scene) {
  const bool is_prepared = capture.prepared_axis.has_value();
  std::vector<glm::dvec3> centres;
  for (const TransformsFrame& frame : capture.frames) centres.push_back(frame.camera.position());
  const glm::dvec3 origin = is_prepared ? glm::dvec3(0) : far_origin(centres);
  scene.points = find_points(folder, capture.points_file, scene.warnings, origin);
  scene.prepared_from_source = capture.prepared_from_source;
  if (is_prepared) return;
  std::vector<Camera> training;
  for (TransformsFrame& frame : capture.frames) {
    frame.camera = camera_in_world(less(origin), frame.camera);
    if (frame.split == Split::kTrain) training.push_back(frame.camera);
  }
  const Similarity change = usable_from_stated(training, scene.points);
  for (TransformsFrame& frame : capture.frames)
    frame.camera = camera_in_world(change, frame.camera);
  move_points(change, scene.points);
  scene.prepared_from_source = compose(change, less(origin));
}

}  // namespace

struct SceneFiles::Listed {
  TransformsCapture capture;      // in the world of the scene
  std::vector<double> time;       // [frame] normalised
  std::vector<int64_t> timestep;  // [frame] Frame::timestep
  Scene scene;                    // without frames
};

SceneFiles::SceneFiles(const std::filesystem::path& folder, bool allow_static) {
  auto listed = std::make_unique<Listed>();
  TransformsCapture& capture = listed->capture = read_transforms(folder);
  Scene& scene = listed->scene;
  scene.path = folder.string();
  scene.warnings = std::move(capture.warnings);
  scene.warnings.insert(scene.warnings.end(), capture.notes.begin(), capture.notes.end());
  place_world(folder, capture, scene);
  NormalisedTimes times = times_of(capture, allow_static);
  scene.time_axis = times.axis;
  scene.is_static = times.is_static;
  std::vector<FrameTime> frames;
  for (size_t i = 0; i < times.time.size(); ++i)
    frames.push_back({capture.frames[i].camera_name, times.time[i], capture.frames[i].split});
  listed->time = std::move(times.time);
  listed->timestep = timestep_numbers(frames);
  listed_ = std::move(listed);
}

SceneFiles::~SceneFiles() = default;

Scene SceneFiles::load(const SceneOptions& options) const {
  const std::vector<TransformsFrame>& all = listed_->capture.frames;
  std::vector<int> chosen(all.size());
  std::iota(chosen.begin(), chosen.end(), 0);
  if (options.timesteps) chosen = frames_at(all, listed_->timestep, chosen, *options.timesteps);
  if (options.held_out) chosen = held_out_of(all, chosen, *options.held_out);
  std::vector<TransformsFrame> frames;
  for (const int i : chosen) frames.push_back(all[size_t(i)]);
  Scene scene = listed_->scene;
  scene.background = options.background;
  load_frames(frames, options, scene);
  for (size_t i = 0; i < chosen.size(); ++i) {
    scene.frames[i].time = listed_->time[size_t(chosen[i])];
    scene.frames[i].timestep = listed_->timestep[size_t(chosen[i])];
  }
  if (!options.held_out) check_splits(scene);
  return scene;
}

Scene load_scene(const std::filesystem::path& folder, const SceneOptions& options) {
  return SceneFiles(folder, options.allow_static).load(options);
}

bool opens_as_scene(const std::filesystem::path& folder) {
  if (!has_transforms(folder)) return false;
  if (is_prepared_scene(folder)) return true;
  try {
    const TransformsCapture capture = read_transforms(folder);
    return std::all_of(capture.frames.begin(), capture.frames.end(),
                       [](const TransformsFrame& frame) { return is_png(frame.image); });
  } catch (const InputError&) {
    return false;  // the conversion reports or corrects the defect
  }
}

}  // namespace tessera
