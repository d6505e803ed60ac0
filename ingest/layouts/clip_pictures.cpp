// Decodes on the calling thread; undistorts, scales and writes on all threads. The decoder waits
// for the writers.
#include "ingest/layouts/rig_clips.h"

#include <optional>

#include "ingest/images/resampling.h"
#include "ingest/layouts/conversion.h"
#include "ingest/layouts/mask_source.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

class ImageWriter {
 public:
  ImageWriter(const std::filesystem::path& folder, double scale,
              const std::optional<Undistortion>& undistortion)
      : folder_(folder), scale_(scale), undistortion_(undistortion) {}

  void add(const std::string& file, Image8 image) {
    waiting_.push_back({file, std::move(image)});
    if (int(waiting_.size()) >= 2 * thread_count()) write();
  }
  void write() {
    parallel_for(int64_t(waiting_.size()), 1, [&](int64_t begin, int64_t end) {
      for (auto i = size_t(begin); i < size_t(end); ++i) {
        Image8 image = std::move(waiting_[i].image);
        if (undistortion_) image = undistortion_->apply(image);
        write_prepared_image(folder_ / waiting_[i].file, std::move(image), scale_);
      }
    });
    waiting_.clear();
  }

 private:
  struct Waiting {
    std::string file;
    Image8 image;
  };
  const std::filesystem::path& folder_;
  double scale_;
  const std::optional<Undistortion>& undistortion_;
  std::vector<Waiting> waiting_;
};

}  // namespace

PreparedClip write_clip_images(const RigClip& clip, const ClipFrames& frames,
                               const std::filesystem::path& folder, const IngestOptions& options,
                               const std::function<void()>& on_image) {
  check(clip.camera.has_value(), "write_clip_pictures: a clip without its camera");
  const Camera& stated = clip.camera->camera;
  Camera camera = stated;
  std::optional<Undistortion> undistortion;
  if (const Lens& lens = clip.camera->lens; !lens.is_pinhole()) {
    const Camera pinhole = undistorted_camera(
        stated, lens, clip.video.string() + " (" + clip.camera->lens_model + ")");
    undistortion.emplace(stated, lens, pinhole);
    camera = pinhole;
  }
  ImageWriter writer(folder, options.scale, undistortion);
  size_t next = 0;
  bool has_alpha = false;
  std::string tone_map = "none";
  decode_clip(clip, frames.ticks, [&](VideoFrame decoded) {
    tone_map = tone_map_of(decoded.colour);
    has_alpha = has_alpha || decoded.image.channels == 4;
    writer.add(frames.files[next++], std::move(decoded.image));
    on_image();
    return true;
  });
  writer.write();
  return {scaled_camera(camera, options.scale),
          prepare_camera_mask(folder, clip.name, stated, clip.camera->lens, camera, options),
          has_alpha, tone_map};
}

}  // namespace tessera
