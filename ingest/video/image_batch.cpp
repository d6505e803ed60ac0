// What: one converter a thread, because swscale's contexts are not shared.
// Not: order by chance: images leave as their frames came.
#include "ingest/video/image_batch.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <fmt/format.h>

#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {

ImageBatch::ImageBatch(const VideoFile& file, const DecodeOptions& options,
                       const std::function<bool(VideoFrame)>& on_frame)
    : name_(file.name()),
      shape_{file.quarter_turns(), options.width, options.height},
      on_frame_(on_frame),
      converters_(size_t(thread_count())) {
  check((options.width > 0) == (options.height > 0) && options.width <= file.width() &&
            options.height <= file.height(),
        "images are handed out in the video's size or smaller");
  for (size_t i = 0; i < converters_.size(); ++i) frames_.push_back(new_frame());
}

bool ImageBatch::add(AVFrame& frame) {
  av_frame_unref(frames_[waiting_].get());
  av_frame_move_ref(frames_[waiting_].get(), &frame);
  return ++waiting_ < frames_.size() || deliver();
}

bool ImageBatch::deliver() {
  std::vector<Image8> images(waiting_);
  parallel_for(int64_t(waiting_), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i) {
      images[i] = converters_[i].convert(*frames_[i], shape_);
      if (images[i].data.empty()) {
        const char* format = av_get_pix_fmt_name(AVPixelFormat(frames_[i]->format));
        const char* matrix = av_color_space_name(frames_[i]->colorspace);
        throw InputError(fmt::format(
            "{}: its pixels ({}, matrix {}) have no conversion to RGB here; encode it again with "
            "`ffmpeg -i IN -pix_fmt yuv420p -colorspace bt709 OUT`",
            name_, format != nullptr ? format : "unknown", matrix != nullptr ? matrix : "unknown"));
      }
    }
  });
  const size_t count = std::exchange(waiting_, 0);
  for (size_t i = 0; i < count && !stopped_; ++i) {
    ++delivered_;
    stopped_ = !on_frame_({frames_[i]->pts, std::move(images[i])});
  }
  for (size_t i = 0; i < count; ++i) av_frame_unref(frames_[i].get());
  return !stopped_;
}

}  // namespace tessera
