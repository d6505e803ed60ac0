// What: rendered pictures as files: 8-bit PNG on the background or with alpha, and exact .pfm.
// Not: rendering or metrics.
#pragma once
#include <filesystem>

#include "recon4d/evaluation/render.h"

namespace tessera {

/// RGB as rendered, clamped and rounded.
void write_picture_png(const std::filesystem::path& path, const Picture& picture);
/// RGBA with straight alpha, of a picture that was rendered on black.
void write_picture_png_alpha(const std::filesystem::path& path, const Picture& picture);
/// RGB floats as rendered, unclamped: PFM, little-endian, bottom row first.
void write_picture_pfm(const std::filesystem::path& path, const Picture& picture);

}  // namespace tessera
