// Reads the images of a camera in chunks on all threads; videos are passed to the video decoder.
#include "ingest/video/clip_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/fnv1a.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/images/image_source.h"
#include "ingest/images/resampling.h"
#include "ingest/video/chapters.h"
#include "ingest/video/frame_timing.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// Seconds a number, as a ratio that states rates like 29.97 exactly.
Rational seconds_of_number(double rate) {
  constexpr int64_t kUnit = 1000;
  const int64_t whole = std::llround(rate);
  if (std::abs(rate - double(whole)) < 1e-9) return {1, whole};
  return {kUnit, std::llround(rate * double(kUnit))};
}

const std::filesystem::path& file_of(const RigClip& clip, int64_t number) {
  const auto found = std::lower_bound(
      clip.images.begin(), clip.images.end(), number,
      [](const NumberedImage& image, int64_t wanted) { return image.number < wanted; });
  check(found != clip.images.end() && found->number == number, "a wanted image is one of the clip");
  return found->file;
}

Image8 read_frame(const RigClip& clip, int64_t number, const DecodeOptions& options) {
  const std::filesystem::path& file = file_of(clip, number);
  Image8 image = read_image(file);
  if (image.width != clip.timeline.width || image.height != clip.timeline.height)
    throw InputError(fmt::format(
        "{}: is {}x{}, the first image of camera {} is {}x{}; use images of one size a camera",
        file.string(), image.width, image.height, clip.name, clip.timeline.width,
        clip.timeline.height));
  if (image.channels == 1) image = composite_on(image, {0, 0, 0});  // grey is repeated
  if (options.width > 0) image = scale_image(image, options.width, options.height);
  return image;
}

void read_images(const RigClip& clip, const std::vector<int64_t>& wanted,
                 const std::function<bool(VideoFrame)>& on_frame, const DecodeOptions& options) {
  const auto chunk = size_t(thread_count());
  for (size_t start = 0; start < wanted.size(); start += chunk) {
    const size_t size = std::min(chunk, wanted.size() - start);
    std::vector<VideoFrame> frames(size);
    std::vector<std::string> errors(size);
    parallel_for(int64_t(size), 1, [&](int64_t begin, int64_t end) {
      for (auto i = size_t(begin); i < size_t(end); ++i) try {
          frames[i] = {wanted[start + i], read_frame(clip, wanted[start + i], options)};
        } catch (const InputError& error) {
          errors[i] = error.what();
        }
    });
    for (size_t i = 0; i < size; ++i) {
      if (!errors[i].empty()) throw InputError(errors[i]);
      if (!on_frame(std::move(frames[i]))) return;
    }
  }
}

}  // namespace

VideoTimeline read_clip_timeline(const RigClip& clip, double image_rate) {
  if (clip.images.empty()) return joined_timeline(clip);
  const Image8 first = read_image(clip.images.front().file);
  VideoTimeline timeline;
  timeline.width = first.width;
  timeline.height = first.height;
  timeline.time_base = clip.number_seconds.value_or(seconds_of_number(image_rate));
  for (const NumberedImage& image : clip.images) timeline.ticks.push_back(image.number);
  timeline.frame_seconds = timeline.time_base.at(median_distance(timeline.ticks));
  timeline.warnings = gap_warnings(fmt::format("{}: camera {}", clip.video.string(), clip.name),
                                   timeline.ticks, timeline.time_base);
  return timeline;
}

void decode_clip(const RigClip& clip, const std::vector<int64_t>& wanted,
                 const std::function<bool(VideoFrame)>& on_frame, const DecodeOptions& options) {
  if (clip.images.empty()) return decode_chapters(clip, wanted, on_frame, options);
  read_images(clip, wanted, on_frame, options);
}

std::string clip_hash(const RigClip& clip) {
  if (clip.images.empty() && clip.chapters.empty()) return source_hash(clip.video);
  Fnv1a hash;
  if (clip.images.empty()) hash.add(source_hash(clip.video));
  for (const std::filesystem::path& chapter : clip.chapters) hash.add(source_hash(chapter));
  for (const NumberedImage& image : clip.images) hash.add(source_hash(image.file));
  return hash.hex();
}

}  // namespace tessera
