// Makes the images and masks of a prepared scene from those of a capture: without lens distortion,
// scaled, as PNG.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "ingest/images/resampling.h"
#include "ingest/ingest.h"
#include "ingest/poses/pinhole_view.h"
#include "ingest/scene.h"

namespace tessera {

/// Calls `convert` for each image, in parallel, chunk by chunk, so that progress comes from the
/// calling thread and can stop the conversion. Errors: the InputError of the first image.
void convert_images(size_t count, const IngestProgress& progress,
                    const std::function<void(size_t)>& convert);

/// What becomes of the images of one camera. Threads may call it at once.
class ImagePreparation {
 public:
  /// `camera`: of the images as stored. Errors: as pinhole_view().
  ImagePreparation(const Camera& camera, const Lens& lens, FieldOfView kept,
                   const std::string& where, double scale);

  /// Of the written images.
  Camera camera() const;
  FieldOfView kept() const { return pinhole_.kept; }
  /// Whether images need a mask.
  bool has_blanks() const { return pinhole_.has_blanks; }
  /// Without distortion and scaled; grey becomes RGB, alpha stays.
  Image8 prepared(Image8 image) const;
  /// A mask of the size of the stored images, or nothing where they have none; what lies beyond
  /// them is ignored.
  void write_mask(const std::filesystem::path& path, std::optional<Image8> mask) const;

 private:
  Camera stored_;
  PinholeView pinhole_;
  Lens lens_;
  double scale_;
  std::optional<Undistortion> undistortion_;  // of a lens
};

}  // namespace tessera
