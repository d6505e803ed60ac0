// The decoder waits while images are converted on all threads.
#include "ingest/steps/clip_images.h"

#include <fmt/format.h>

#include <utility>

#include "ingest/video/clip_frames.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

RigClip rig_clip_of(const SceneClip& clip) {
  RigClip rig{.name = clip.camera, .video = clip.files.front(), .timeline = {}, .camera = {}};
  rig.chapters.assign(clip.files.begin() + 1, clip.files.end());
  rig.timeline.width = clip.stored.width;
  rig.timeline.height = clip.stored.height;
  rig.timeline.time_base = clip.time_base;
  rig.timeline.chapters = clip.chapters;
  return rig;
}

class VideoClipReader : public ClipReader {
 public:
  void read(const SceneClip& clip, const std::vector<int64_t>& ticks,
            const std::function<void(size_t, Image8)>& on_image) const override {
    check_source(clip);
    const ImagePreparation preparation(
        clip.stored, clip.lens, clip.field_of_view,
        fmt::format("{} ({})", clip.files.front().string(), clip.lens_model), clip.scale);
    prepare_clip_images(
        rig_clip_of(clip), ticks, preparation, [](const VideoFrame&) {}, on_image);
  }
};

}  // namespace

void prepare_clip_images(const RigClip& clip, const std::vector<int64_t>& ticks,
                         const ImagePreparation& preparation,
                         const std::function<void(const VideoFrame&)>& on_decoded,
                         const std::function<void(size_t, Image8)>& on_image) {
  std::vector<std::pair<size_t, Image8>> waiting;
  const auto convert = [&] {
    parallel_for(int64_t(waiting.size()), 1, [&](int64_t begin, int64_t end) {
      for (auto i = size_t(begin); i < size_t(end); ++i)
        on_image(waiting[i].first, preparation.prepared(std::move(waiting[i].second)));
    });
    waiting.clear();
  };
  size_t next = 0;
  decode_clip(clip, ticks, [&](VideoFrame decoded) {
    on_decoded(decoded);
    waiting.emplace_back(next++, std::move(decoded.image));
    if (int(waiting.size()) >= 2 * thread_count()) convert();
    return true;
  });
  convert();
}

const ClipReader* video_clip_reader() {
  static const VideoClipReader reader;
  return &reader;
}

}  // namespace tessera
