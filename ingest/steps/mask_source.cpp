// Resamples a mask as a grey image and applies a threshold afterwards.
#include "ingest/steps/mask_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "ingest/images/alpha_and_mask.h"
#include "ingest/images/image_source.h"
#include "ingest/images/resampling.h"
#include "ingest/layouts/mask_files.h"
#include "ingest/poses/intrinsics.h"
#include "ingest/steps/steps.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

Image8 cut_at_half(Image8 mask) {
  for (uint8_t& value : mask.data) value = value > 127 ? 255 : 0;
  return mask;
}

/// With a border of one ignored pixel, which is what resampling repeats beyond it.
Image8 with_border(const Image8& mask) {
  Image8 wider{mask.width + 2, mask.height + 2, 1, {}};
  wider.data.resize(size_t(wider.width) * size_t(wider.height));
  for (int y = 0; y < mask.height; ++y)
    std::copy_n(mask.data.data() + size_t(y) * size_t(mask.width), mask.width,
                wider.data.data() + size_t(y + 1) * size_t(wider.width) + 1);
  return wider;
}

const RigClip& clip_of_frame(const Capture& capture, const CaptureFrame& frame) {
  return *std::find_if(capture.clips.begin(), capture.clips.end(),
                       [&](const RigClip& clip) { return clip.name == frame.frame.camera_name; });
}

/// The names that the mask of a frame may have, for people.
std::string sought_masks(const CaptureFrame& frame) {
  if (frame.ticks)
    return fmt::format(
        "{0}/00000.png or {0}_00000.png (frames of the clip, counted from 0) and "
        "{0}.png (of all frames)",
        frame.frame.camera_name);
  return fmt::format("{}.png (a.png or a.jpg.png for a.jpg)",
                     std::filesystem::path(frame.image_name).replace_extension().string());
}

}  // namespace

Image8 read_mask(const std::filesystem::path& file, int width, int height,
                 const IngestOptions& options, std::atomic<int64_t>& object_masks) {
  const Image8 image = read_image(file);
  Image8 mask = mask_of_image(image, file);
  if (has_object_numbers(image)) ++object_masks;
  if (mask.width > width && same_shape(mask.width, mask.height, width, height))
    mask = cut_at_half(scale_image(mask, width, height));
  check_mask_size(mask, width, height, file);
  if (options.invert_masks) invert_mask(mask);
  return mask;
}

Image8 whole_mask(int width, int height) {
  return {width, height, 1, std::vector<uint8_t>(size_t(width) * size_t(height), 255)};
}

Image8 undistorted_mask(const Image8& mask, const Camera& camera, const Lens& lens,
                        const Camera& pinhole) {
  if (lens.is_pinhole()) return mask;
  Camera wider = camera;
  wider.width += 2;
  wider.height += 2;
  wider.cx += 1;
  wider.cy += 1;
  return cut_at_half(Undistortion(wider, lens, pinhole).apply(with_border(mask)));
}

Image8 scaled_mask(const Image8& mask, double scale) {
  return cut_at_half(
      scale_image(mask, scaled_side(mask.width, scale), scaled_side(mask.height, scale)));
}

void note_object_masks(int64_t count, Capture& capture) {
  if (count > 0)
    capture.notes.push_back(fmt::format(
        "{} masks have the numbers or colours of objects: what is not black there is used", count));
}

Capture find_masks(Capture capture, const StepContext& context) {
  if (context.options.masks.empty()) return capture;
  MaskFiles files(context.options.masks);
  std::map<std::string, std::vector<std::filesystem::path>> of_clips;  // one a frame of the clip
  for (const RigClip& clip : capture.clips)
    of_clips[clip.name] = files.of_clip(clip, capture.clips.size() == 1);
  for (CaptureFrame& frame : capture.frames) {
    if (!frame.ticks) {
      frame.mask = files.of_image(frame.image_name);
      continue;
    }
    const RigClip& clip = clip_of_frame(capture, frame);
    const auto& ticks = clip.timeline.ticks;
    const auto index = std::lower_bound(ticks.begin(), ticks.end(), *frame.ticks) - ticks.begin();
    frame.mask = of_clips[clip.name][size_t(index)];
  }
  for (std::string& line : files.warnings()) capture.warnings.push_back(std::move(line));
  for (std::string& line : files.notes()) capture.notes.push_back(std::move(line));
  return capture;
}

Capture check_masks(Capture capture, const StepContext& context) {
  const IngestOptions& options = context.options;
  const auto without = std::count_if(capture.frames.begin(), capture.frames.end(),
                                     [](const CaptureFrame& frame) { return frame.mask.empty(); });
  capture.inverted_masks = options.invert_masks;
  const bool none = size_t(without) == capture.frames.size();
  if (!options.masks.empty() && none)
    throw InputError(fmt::format("{}: has no mask for any of the {} frames; looked for {}; has {}",
                                 options.masks.string(), capture.frames.size(),
                                 sought_masks(capture.frames.front()),
                                 contents_of_masks(options.masks)));
  if (options.invert_masks && none)
    throw InputError(
        "--invert-masks is given, but there are no masks; pass --masks or leave it out");
  if (!options.masks.empty() && without > 0)
    capture.warnings.push_back(
        fmt::format("{}: {} of {} frames have no mask, all their pixels count",
                    options.masks.string(), without, capture.frames.size()));
  return capture;
}

}  // namespace tessera
