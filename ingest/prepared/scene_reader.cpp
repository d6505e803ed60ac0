// Chooses the frames that are loaded.
#include "ingest/prepared/scene_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "ingest/prepared/frame_pixels.h"
#include "ingest/prepared/listed_scene.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

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

void check_splits(const Scene& scene) {
  const bool trains = std::any_of(scene.frames.begin(), scene.frames.end(),
                                  [](const Frame& frame) { return frame.split == Split::kTrain; });
  if (!trains)
    throw InputError(
        fmt::format("{}: no frame is in the split 'train'; mark some as training", scene.path));
}

}  // namespace

SceneFiles::SceneFiles(const std::filesystem::path& folder, bool allow_static,
                       const std::optional<Window>& window) {
  ListedScene listed = list_scene(folder, allow_static);
  if (window) listed.cut(*window);
  listed_ = std::make_unique<const ListedScene>(std::move(listed));
}

SceneFiles::~SceneFiles() = default;

Scene SceneFiles::load(const SceneOptions& options) const {
  const std::vector<TransformsFrame>& all = listed_->capture.frames;
  std::vector<int> chosen(all.size());
  std::iota(chosen.begin(), chosen.end(), 0);
  if (options.frames) chosen = *options.frames;
  if (options.timesteps) chosen = frames_at(all, listed_->timestep, chosen, *options.timesteps);
  if (options.held_out) chosen = held_out_of(all, chosen, *options.held_out);
  std::vector<TransformsFrame> frames;
  for (const int i : chosen) frames.push_back(all[size_t(i)]);
  Scene scene = listed_->scene;
  scene.background = options.background;
  load_frames(frames, listed_->capture.clips, options, scene);
  for (size_t i = 0; i < chosen.size(); ++i) {
    scene.frames[i].time = listed_->time[size_t(chosen[i])];
    scene.frames[i].timestep = listed_->timestep[size_t(chosen[i])];
  }
  if (!options.held_out && !options.frames) check_splits(scene);
  return scene;
}

Scene load_scene(const std::filesystem::path& folder, const SceneOptions& options) {
  return SceneFiles(folder, options.allow_static, options.window).load(options);
}

Scene scene_without_pixels(const std::filesystem::path& folder, bool allow_static,
                           const std::optional<Window>& window) {
  SceneOptions options;
  options.load_pixels = false;
  return SceneFiles(folder, allow_static, window).load(options);
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
