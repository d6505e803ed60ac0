// Reads or copies the frames of a few timesteps at a time.
#include "ingest/cloud/cloud_frames.h"

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// All of a frame but its pixels; its split that of the files.
Frame without_pixels(const Frame& frame) {
  const Image8& image = frame.image;
  Frame listed{frame.name,     frame.camera_name, frame.frame_number, frame.time,
               frame.timestep, frame.split,       frame.camera,       {},
               frame.mask};
  listed.image = {image.width, image.height, image.channels, {}};
  if (listed.split == Split::kValidation) listed.split = Split::kTrain;
  return listed;
}

}  // namespace

FolderFrames::FolderFrames(const std::filesystem::path& folder, const std::optional<Window>& window)
    : files_(folder, true, window) {
  SceneOptions options;
  options.load_pixels = false;
  listed_ = files_.load(options);
}

Scene FolderFrames::at(const std::vector<int64_t>& timesteps) const {
  SceneOptions options;
  options.timesteps = timesteps;
  return files_.load(options);
}

SceneFrames::SceneFrames(const Scene& scene) : scene_(scene) {
  for (const Frame& frame : scene.frames) listed_.frames.push_back(without_pixels(frame));
}

Scene SceneFrames::at(const std::vector<int64_t>& timesteps) const {
  Scene found;
  std::vector<size_t> from;
  for (const int64_t timestep : timesteps)
    for (size_t i = 0; i < listed_.frames.size(); ++i) {
      const Frame& frame = listed_.frames[i];
      if (frame.split != Split::kTrain || frame.timestep != timestep) continue;
      from.push_back(i);
      found.frames.push_back(frame);
    }
  parallel_for(int64_t(from.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      found.frames[size_t(i)].image = scene_.frames[from[size_t(i)]].image;
  });
  return found;
}

}  // namespace tessera
