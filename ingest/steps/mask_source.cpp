// Resamples a mask as a grey image and applies a threshold afterwards.
#include "ingest/steps/mask_source.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/images/alpha_and_mask.h"
#include "ingest/images/image_source.h"
#include "ingest/images/resampling.h"
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

}  // namespace

std::filesystem::path find_mask(const IngestOptions& options, const std::filesystem::path& image) {
  if (options.masks.empty()) return {};
  const std::filesystem::path whole = options.masks / image;
  std::filesystem::path stem = whole;
  stem.replace_extension();
  for (const char* extension : {".png", ".PNG", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp"})
    for (std::filesystem::path path : {whole, stem})
      if (path += extension; std::filesystem::is_regular_file(path)) return path;
  return {};
}

Image8 read_mask(const std::filesystem::path& file, int width, int height,
                 const IngestOptions& options) {
  Image8 mask = mask_of_image(read_image(file), file);
  if (mask.width > width && same_shape(mask.width, mask.height, width, height))
    mask = cut_at_half(scale_image(mask, width, height));
  check_mask_size(mask, width, height, file);
  if (options.invert_masks) invert_mask(mask);
  return mask;
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

Capture find_masks(Capture capture, const StepContext& context) {
  if (context.options.masks.empty()) return capture;
  for (CaptureFrame& frame : capture.frames)
    frame.mask = find_mask(context.options,
                           frame.image_name.empty() ? frame.frame.camera_name : frame.image_name);
  return capture;
}

Capture check_masks(Capture capture, const StepContext& context) {
  const IngestOptions& options = context.options;
  const auto without =
      std::count_if(capture.frames.begin(), capture.frames.end(),
                    [](const CaptureFrame& frame) { return frame.mask_path.empty(); });
  capture.inverted_masks = options.invert_masks;
  const bool none = size_t(without) == capture.frames.size();
  if (!options.masks.empty() && none)
    throw InputError(fmt::format(
        "{}: has no mask for any of the {} frames; name masks as the images (a.png or a.jpg.png "
        "for a.jpg) or, for videos, as the cameras",
        options.masks.string(), capture.frames.size()));
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
