// The places of pixels are computed once a camera.
#include "ingest/steps/prepared_image.h"

#include <algorithm>
#include <vector>

#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/steps/mask_source.h"
#include "kernels/base/parallel.h"

namespace tessera {

void convert_images(size_t count, const IngestProgress& progress,
                    const std::function<void(size_t)>& convert) {
  const size_t chunk = 4 * size_t(thread_count());
  for (size_t start = 0; start < count; start += chunk) {
    const size_t size = std::min(chunk, count - start);
    std::vector<std::string> errors(size);
    parallel_for(int64_t(size), 1, [&](int64_t begin, int64_t end) {
      for (auto i = size_t(begin); i < size_t(end); ++i) try {
          convert(start + i);
        } catch (const InputError& error) {
          errors[i] = error.what();
        }
    });
    for (const std::string& error : errors)
      if (!error.empty()) throw InputError(error);
    progress("converting images", int64_t(start + size), int64_t(count));
  }
}

ImagePreparation::ImagePreparation(const Camera& camera, const Lens& lens, FieldOfView kept,
                                   const std::string& where, double scale)
    : stored_(camera),
      pinhole_(pinhole_view(camera, lens, kept, where)),
      lens_(lens),
      scale_(scale) {
  if (!lens.is_pinhole()) undistortion_.emplace(camera, lens, pinhole_.camera);
}

Camera ImagePreparation::camera() const {
  const Camera& pinhole = pinhole_.camera;
  return pinhole.resized(scaled_side(pinhole.width, scale_), scaled_side(pinhole.height, scale_));
}

Image8 ImagePreparation::prepared(Image8 image) const {
  if (undistortion_) image = undistortion_->apply(image);
  image = scale_image(image, scaled_side(image.width, scale_), scaled_side(image.height, scale_));
  return image.channels == 1 ? composite_on(image, {0, 0, 0})
                             : image;  // grey has no alpha: repeated
}

void ImagePreparation::write_mask(const std::filesystem::path& path,
                                  std::optional<Image8> mask) const {
  if (!mask) mask = whole_mask(stored_.width, stored_.height);
  write_png(path, scaled_mask(undistorted_mask(*mask, stored_, lens_, pinhole_.camera), scale_));
}

}  // namespace tessera
