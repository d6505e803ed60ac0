// Reads an image of any format as an Image8 in sRGB, with its EXIF orientation. Pixels keep their
// stored order, or are turned upright where that matches the pose.
#pragma once
#include <filesystem>

#include "ingest/scene.h"

namespace tessera {

/// How linear images become 8-bit sRGB; recorded in the prepared scene.
inline constexpr const char* kToneMap = "clamp to [0, 1], sRGB transfer curve";

struct SourceImage {
  Image8 image;
  int orientation = 1;        // EXIF, 1 to 8: how a viewer would turn it; 1 by default
  bool tone_mapped = false;   // it was linear: floating-point pixels (EXR, TIFF)
  std::string converted{};    // the colour profile that its values had; empty: sRGB
  std::string unconverted{};  // a profile of a kind that is not converted
};

/// Grey, RGB or RGBA with alpha not premultiplied. Integers are sRGB, converted from a profile of
/// another colour space (Display P3, Adobe RGB), 16 bit is reduced with rounding; floating-point
/// pixels are linear and go through kToneMap: c → clamp(c, 0, 1), then 12.92 c up to 0.0031308
/// and 1.055 c^(1/2.4) − 0.055 above; alpha has no curve. The format is that of the file's first
/// bytes where these are known. Errors: InputError naming the file: unreadable, truncated, damaged,
/// CMYK, two or more than four channels.
SourceImage read_source_image(const std::filesystem::path& path);

/// The pixels alone.
Image8 read_image(const std::filesystem::path& path);

/// As a viewer shows it. Orientation 1 to 8 of EXIF: 2 mirrored, 3 turned by 180°, 4 flipped, 6
/// turned clockwise, 8 anticlockwise, 5 and 7 the mirrored ones of those.
Image8 turned_upright(const Image8& stored, int orientation);

/// The pixels that a camera of `width` × `height` (of any size of the same shape) describes: as
/// stored or turned upright, by the shape. Where both fit, as stored, because COLMAP (3.8) and the
/// usual loaders ignore the tag; `doubtful` then becomes true. Where neither fits: as
/// stored.
Image8 image_as_posed(SourceImage source, int width, int height, bool& doubtful);

}  // namespace tessera
