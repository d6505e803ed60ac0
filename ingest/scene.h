// A capture in memory as plain data: frames with cameras and times, and an initial cloud. This is
// the only header of a scene that the training includes.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kernels/base/camera.h"
#include "kernels/base/enum_names.h"
#include "kernels/base/similarity.h"

namespace tessera {

/// kValidation: training frames by which a training chooses its model; no file states this split.
enum class Split { kTrain, kVal, kTest, kValidation };
template <>
inline constexpr const char* kEnumNames<Split>[] = {"train", "val", "test", "aside"};

/// 8-bit interleaved image, row-major, top row first.
struct Image8 {
  int width = 0, height = 0, channels = 0;  // channels: 1, 3 or 4
  std::vector<uint8_t> data;                // [height, width, channels]
};

/// Which pixels of a frame are used. Frames that are made with one mask file share its pixels.
class FrameMask {
 public:
  FrameMask() = default;  // all pixels are used
  /// `image`: one channel, 0: the pixel is ignored, 255: it is used; without data: of a scene whose
  /// pixels are not loaded.
  FrameMask(Image8 image) : image_(std::make_shared<const Image8>(std::move(image))) {}

  /// [height, width], or empty where all pixels are used.
  const std::vector<uint8_t>& data() const { return image().data; }
  const Image8& image() const {
    static const Image8 none;
    return image_ ? *image_ : none;
  }
  bool ignores(int x, int y) const {
    return !data().empty() && data()[size_t(y) * size_t(image_->width) + size_t(x)] == 0;
  }
  /// What frames that share their pixels have in common; null: all pixels are used.
  const Image8* shared() const { return image_.get(); }

 private:
  std::shared_ptr<const Image8> image_;
};

struct Frame {
  std::string name;          // unique in the scene, e.g. "train/r_003" or "cam02/00017"
  std::string camera_name;   // physical camera: "cam02"; for monocular captures the split's name
  int64_t frame_number = 0;  // index of the frame in that camera
  double time = 0;           // normalised to [0, 1] over all splits; by its camera's own clock
  /// Number of its timestep over the whole clip (ingest/clocks/timesteps.h); −1: not numbered yet.
  /// Frames of one timestep have the same, whatever their clocks.
  int64_t timestep = -1;
  Split split = Split::kTrain;
  Camera camera;
  Image8 image;  // RGB, composited once on Scene::background; without data: not loaded
  FrameMask mask;
};

struct PointCloud {
  std::vector<glm::vec3> position;             // [P] world units
  std::vector<std::array<uint8_t, 3>> colour;  // [P] sRGB, same length as position
  // Columns about time, each empty or [P].
  std::vector<float> time;     // timestep at which it was seen, normalised; NaN: not known
  std::vector<uint8_t> still;  // 1: looks the same at all times, 0: not, kStillUnknown
  static constexpr uint8_t kStillUnknown = 255;
  // Empty or [P] world units per unit of normalised time; 0: at rest, or not known.
  std::vector<glm::vec3> velocity{};
};

/// time = (source_time − origin) / duration; source_time in the capture's own unit.
struct TimeAxis {
  double origin = 0;
  double duration = 1;    // 0 never: a single-timestep scene keeps 1
  bool is_stated = true;  // false: a file has normalised times alone, and these are a guess
};

struct Scene {
  std::string path;           // folder it was read from
  std::vector<Frame> frames;  // in the order of the files
  PointCloud points;          // may be empty
  TimeAxis time_axis;
  Similarity prepared_from_source;  // what was done to the world; identity where nothing was
  std::set<std::string> measured_clocks{};  // cameras whose times motion or sound moved
  bool is_static = false;  // one timestep (no times given, or all equal and allowed)
  // Of what stands still in a clip (ingest/derived/static_scene.h): timesteps of that clip; else
  // 0.
  int64_t static_of = 0;
  // [cameras] what stands still over a longer clip that this is a window of: images, and masks that
  // ignore what does not; empty: not known.
  std::vector<Frame> stills{};
  std::array<uint8_t, 3> background{0, 0, 0};  // sRGB colour that RGBA frames were composited on
  bool had_alpha = false;             // some frame had an alpha channel: empty space is known
  std::vector<std::string> warnings;  // one line each, for tools/ to print

  /// Indices into `frames` of one split, in file order.
  std::vector<int> split_indices(Split split) const {
    std::vector<int> indices;
    for (int i = 0; i < int(frames.size()); ++i)
      if (frames[i].split == split) indices.push_back(i);
    return indices;
  }
  /// How many timesteps the frames of a split have.
  int64_t timesteps_of(Split split) const {
    std::set<int64_t> timesteps;
    for (const Frame& frame : frames)
      if (frame.split == split) timesteps.insert(frame.timestep);
    return int64_t(timesteps.size());
  }
  /// The camera of each training frame, in file order.
  std::vector<Camera> training_cameras() const {
    std::vector<Camera> cameras;
    for (const Frame& frame : frames)
      if (frame.split == Split::kTrain) cameras.push_back(frame.camera);
    return cameras;
  }
};

}  // namespace tessera
