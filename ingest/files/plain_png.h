// Decodes the PNG files that nearly all scenes consist of, and encodes them, several times faster
// than libpng. It says nothing about the other files: libpng reads or refuses them.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "ingest/scene.h"

namespace tessera {

constexpr uint32_t kMaxPngSide = 1 << 20;    // pixels; libpng's own default limit is near it
constexpr uint32_t kDeflateMaxRatio = 1032;  // bytes out per byte in, the most deflate can do

/// The number of four bytes, as PNG has all of its numbers.
inline uint32_t big_endian_32(const uint8_t* bytes) {
  return uint32_t(bytes[0]) << 24 | uint32_t(bytes[1]) << 16 | uint32_t(bytes[2]) << 8 | bytes[3];
}

/// The pixels of a whole file of 8-bit grey, RGB or RGBA without interlacing and without
/// transparency of one colour. Nothing where the file is of another kind or where anything in it is
/// damaged. `file` is also the place where the compressed data are joined.
std::optional<Image8> decode_plain_png(std::span<uint8_t> file);

/// The whole file of an image of 1, 3 or 4 channels.
std::string encode_plain_png(const Image8& image);

}  // namespace tessera
