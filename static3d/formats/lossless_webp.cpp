// Calls libwebp, where the build has it.
#include "static3d/formats/lossless_webp.h"

#include <fmt/format.h>
#ifdef TESSERA_HAS_WEBP
#include <webp/decode.h>
#include <webp/encode.h>
#endif

#include "kernels/base/errors.h"

namespace tessera {

#ifdef TESSERA_HAS_WEBP
void check_webp(const std::filesystem::path&) {}

std::string encode_lossless_webp(const RgbaImage& image) {
  constexpr int kEffort = 4;  // of 0 to 9
  WebPConfig config;
  WebPPicture picture;
  check(WebPConfigInit(&config) != 0 && WebPConfigLosslessPreset(&config, kEffort) != 0 &&
            WebPPictureInit(&picture) != 0,
        "encode_lossless_webp: another version of libwebp");
  config.exact = 1;  // colours of transparent pixels are data
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.use_argb = 1;
  picture.width = image.width;
  picture.height = image.height;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const auto* const rgba = reinterpret_cast<const uint8_t*>(image.bytes.data());
  const bool done = WebPPictureImportRGBA(&picture, rgba, 4 * image.width) != 0 &&
                    WebPEncode(&config, &picture) != 0;
  std::string bytes(reinterpret_cast<const char*>(writer.mem), done ? writer.size : 0);
  WebPPictureFree(&picture);
  WebPMemoryWriterClear(&writer);
  check(done, "encode_lossless_webp: libwebp");
  return bytes;
}

RgbaImage decode_webp(std::string_view bytes, int64_t most_pixels,
                      const std::filesystem::path& path, const std::string& name) {
  const auto* const data = reinterpret_cast<const uint8_t*>(bytes.data());
  int width = 0, height = 0;
  if (WebPGetInfo(data, bytes.size(), &width, &height) == 0)
    throw InputError(
        fmt::format("{}: '{}' is no WebP image; export it again", path.string(), name));
  if (int64_t(width) * height > most_pixels)
    throw InputError(
        fmt::format("{}: '{}' has {} x {} pixels, expected at most {}; export it again",
                    path.string(), name, width, height, most_pixels));
  RgbaImage image(width, height);
  if (WebPDecodeRGBAInto(data, bytes.size(), reinterpret_cast<uint8_t*>(image.bytes.data()),
                         image.bytes.size(), 4 * width) == nullptr)
    throw InputError(
        fmt::format("{}: the image '{}' is damaged; fetch it again", path.string(), name));
  return image;
}
#else
void check_webp(const std::filesystem::path& path) {
  throw InputError(
      fmt::format("{}: .sog needs libwebp, and this build has none; install libwebp-dev and build "
                  "again, or use "
                  "the format spz",
                  path.string()));
}

std::string encode_lossless_webp(const RgbaImage&) {
  throw InputError("this build has no libwebp; install libwebp-dev and build again");
}

RgbaImage decode_webp(std::string_view, int64_t, const std::filesystem::path& path,
                      const std::string&) {
  check_webp(path);
  return {0, 0};
}
#endif

}  // namespace tessera
