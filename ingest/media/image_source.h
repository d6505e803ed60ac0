// What: a source picture of any format → Image8, values as stored (8-bit sRGB assumed).
// Not: video (video_decoder.h), and no tone mapping: linear float pictures are refused.
#pragma once
#include <filesystem>

#include "ingest/scene.h"

namespace tessera {

/// Grey, RGB or RGBA with alpha not premultiplied; 16 bit is reduced with rounding. Errors:
/// InputError naming the file: unreadable, truncated, float pixels, two or more than four channels.
Image8 read_picture(const std::filesystem::path& path);

}  // namespace tessera
