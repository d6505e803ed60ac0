// Lossless WebP images of four channels in memory, by libwebp. A build without libwebp reports what
// to install. Source: RFC 9649.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tessera {

struct RgbaImage {
  int width = 0, height = 0;
  std::string bytes;  // [height, width, 4], rows from the top

  RgbaImage(int w, int h) : width(w), height(h), bytes(size_t(w) * size_t(h) * 4, '\0') {}
  int64_t pixels() const { return int64_t(width) * height; }
  uint8_t& at(int64_t pixel, int channel) {
    return reinterpret_cast<uint8_t&>(bytes[size_t(4 * pixel + channel)]);
  }
  uint8_t at(int64_t pixel, int channel) const {
    return uint8_t(bytes[size_t(4 * pixel + channel)]);
  }
};

inline constexpr int kMostWebpSide = 16383;  // pixels

/// Errors: InputError naming `path`: a build without libwebp.
void check_webp(const std::filesystem::path& path);
/// Colours of transparent pixels are kept.
std::string encode_lossless_webp(const RgbaImage& image);
/// Errors: InputError naming `path` and `name`: no WebP, damaged, more than `most_pixels`.
RgbaImage decode_webp(std::string_view bytes, int64_t most_pixels,
                      const std::filesystem::path& path, const std::string& name);

}  // namespace tessera
