// Reads the images of a photo set, and records which are unreadable and how the others were
// changed.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ingest/capture/capture.h"
#include "ingest/images/image_source.h"

namespace tessera {

/// Images that cannot be read are left out of the scene and named, or, under `strict`, refused.
/// Member functions of different `index` may be called at once.
class ImageIntake {
 public:
  explicit ImageIntake(size_t count) : images_(count) {}

  /// The image in the order of pixels that a camera of width × height describes (0 × 0: as
  /// stored); nothing where it cannot be read.
  std::optional<Image8> read(size_t index, const std::filesystem::path& file, int width,
                             int height);

  /// Takes what was not read out of `capture`, whose frames are in the order of `index`, notes tone
  /// mapping, colour profiles and alpha in it, and adds a warning for each image left out. Errors:
  /// InputError: an image was left out and `strict`; none is left, or none to train on; most are
  /// transparent.
  void finish(bool strict, Capture& capture) const;

 private:
  struct Image {
    std::string unreadable;              // why; empty where it was read
    std::string converted, unconverted;  // names of colour profiles; empty: sRGB
    bool doubtful = false;               // its EXIF orientation may belong to the pose or not
    bool is_empty = false;               // nothing of it is opaque
    bool tone_mapped = false, had_alpha = false;
  };
  std::string profiles_text(std::string Image::*name) const;

  std::vector<Image> images_;
};

}  // namespace tessera
