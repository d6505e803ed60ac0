// Decodes the PNG files in parallel, checks their sizes and composites alpha.
#include "ingest/prepared/frame_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>

#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

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

/// Decodes and composites one frame, or reads its size only; of a clip's frame everything but its
/// pixels. True when it had alpha.
bool load_frame(const TransformsFrame& listed, const SceneOptions& options, bool with_pixels,
                MaskFiles& masks, Frame& frame) {
  frame.name = listed.name;
  frame.camera_name = listed.camera_name;
  frame.frame_number = listed.frame_number;
  frame.split = listed.split;
  frame.camera = listed.camera;
  if (listed.clip >= 0) {
    frame.image = {frame.camera.width, frame.camera.height, 3, {}};
    frame.mask = masks.of(listed, frame.image.width, frame.image.height);
    return false;
  }
  require_png(listed.image, listed.where);
  Image8 image = with_pixels ? read_png(listed.image) : read_png_size(listed.image);
  set_intrinsics(frame.camera, listed.intrinsics, image.width, image.height, listed.where);
  frame.mask = masks.of(listed, image.width, image.height);
  const bool had_alpha = image.channels == 4;
  frame.image = {image.width, image.height, 3, {}};
  if (with_pixels)
    frame.image = image.channels == 3 ? std::move(image) : composite_on(image, options.background);
  return had_alpha;
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

/// The wanted frames of one clip, in the order of their ticks.
void load_clip(const SceneClip& clip, int index, const std::vector<TransformsFrame>& frames,
               const std::vector<bool>& with_pixels, Scene& scene) {
  std::vector<std::pair<int64_t, size_t>> wanted;  // ticks, frame
  for (size_t i = 0; i < frames.size(); ++i)
    if (frames[i].clip == index && with_pixels[i]) wanted.emplace_back(frames[i].ticks, i);
  if (wanted.empty()) return;
  if (clip_reader() == nullptr)
    throw InputError(fmt::format(
        "{}: its frames are in {}, and this build reads no videos; write them as images "
        "by `tessera unpack` of a full build",
        scene.path, clip.files.front().string()));
  std::sort(wanted.begin(), wanted.end());
  std::vector<int64_t> ticks;
  for (const auto& [at, frame] : wanted) ticks.push_back(at);
  clip_reader()->read(clip, ticks, [&](size_t k, Image8 image) {
    scene.frames[wanted[k].second].image = std::move(image);
  });
}

}  // namespace

bool is_png(const std::filesystem::path& file) {
  return file.extension() == ".png" || file.extension() == ".PNG";
}

void load_frames(const std::vector<TransformsFrame>& frames, const std::vector<SceneClip>& clips,
                 const SceneOptions& options, Scene& scene) {
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
  for (size_t c = 0; c < clips.size(); ++c) load_clip(clips[c], int(c), frames, with_pixels, scene);
}

}  // namespace tessera
