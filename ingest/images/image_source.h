// What: a source image of any format → Image8 in sRGB, pixels in the order they are stored.
// Not: video (video_decoder.h), or turning an image upright (image_orientation.h).
#pragma once
#include <filesystem>

#include "ingest/scene.h"

namespace tessera {

/// How linear images become 8-bit sRGB; recorded in the prepared scene.
inline constexpr const char* kToneMap = "clamp to [0, 1], sRGB transfer curve";

struct SourceImage {
  Image8 image;
  int orientation = 1;       // EXIF, 1 to 8: how a viewer would turn it; 1 where it says nothing
  bool tone_mapped = false;  // it was linear: floating-point pixels (EXR, TIFF)
};

/// Grey, RGB or RGBA with alpha not premultiplied. Integers are sRGB as stored, 16 bit is reduced
/// with rounding; floating-point pixels are linear and go through kToneMap: c → clamp(c, 0, 1),
/// then 12.92 c up to 0.0031308 and 1.055 c^(1/2.4) − 0.055 above; alpha has no curve. The format
/// goes by the file's first bytes where they tell. Errors: InputError naming the file: unreadable,
/// truncated, damaged, CMYK, two or more than four channels.
SourceImage read_source_image(const std::filesystem::path& path);

/// The pixels alone.
Image8 read_image(const std::filesystem::path& path);

}  // namespace tessera
