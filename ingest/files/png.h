// Reads and writes 8-bit PNG, the format of prepared frames and of renders.
#pragma once
#include <filesystem>

#include "ingest/scene.h"

namespace tessera {

/// Grey, RGB or RGBA, 8 bit (16 bit is reduced, palettes are expanded). Errors: InputError naming
/// the file and what is wrong: missing, not a PNG, truncated, zero size, CRC.
Image8 read_png(const std::filesystem::path& path);
/// Width, height and channels as read_png would give them, without pixels. Same errors, as far as
/// the header shows them.
Image8 read_png_size(const std::filesystem::path& path);
/// Writes atomically; 1, 3 or 4 channels. Errors: InputError when the file cannot be written.
void write_png(const std::filesystem::path& path, const Image8& image);

}  // namespace tessera
