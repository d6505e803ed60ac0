// Writes rendered images as 8-bit PNG, on the background or with alpha, and as exact .pfm.
#pragma once
#include <filesystem>

#include "recon4d/evaluation/render.h"

namespace tessera {

/// RGB as rendered, clamped and rounded.
void write_image_png(const std::filesystem::path& path, const RenderedImage& image);
/// RGBA with straight alpha, of an image that was rendered on black.
void write_image_png_alpha(const std::filesystem::path& path, const RenderedImage& image);
/// RGB floats as rendered, unclamped: PFM, little-endian, bottom row first.
void write_image_pfm(const std::filesystem::path& path, const RenderedImage& image);

}  // namespace tessera
