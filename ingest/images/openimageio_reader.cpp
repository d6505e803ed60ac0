// The module libtessera_openimageio.so: reads an image through OpenImageIO. Floats are linear with
// sRGB primaries. Source of the transfer curve: IEC 61966-2-1.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/images/openimageio_module.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using std::filesystem::path;

[[noreturn]] void fail(const path& file, const std::string& seen) {
  throw InputError(
      fmt::format("{}: {}; convert this image to 8-bit sRGB PNG", file.string(), seen));
}

/// What cannot become RGB or grey without a guess.
void check_spec(const path& file, const OIIO::ImageSpec& spec) {
  if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1)
    fail(file, fmt::format("has size {}x{}x{}", spec.width, spec.height, spec.depth));
  constexpr int kTiffSeparated = 5;
  const auto jpeg_colour = spec.get_string_attribute("jpeg:ColorSpace");
  if (jpeg_colour == "CMYK" || jpeg_colour == "YCCK" ||
      spec.get_int_attribute("tiff:PhotometricInterpretation") == kTiffSeparated)
    fail(file, "is CMYK, which has no one meaning in RGB");
  const bool has_alpha = spec.nchannels == 4 && spec.alpha_channel == 3;
  if (spec.nchannels != 1 && spec.nchannels != 3 && !has_alpha)
    fail(file, fmt::format("has {} channels{}, expected grey, RGB or RGBA", spec.nchannels,
                           spec.nchannels == 4 ? ", the last of which is not alpha" : ""));
}

float srgb_from_linear(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

/// NaN becomes 0.
float clamped(float value) {
  return value > 0 ? std::min(value, 1.0f) : 0.0f;
}

/// Associated alpha undone, then the tone map where the values are linear, then 8 bit.
std::vector<uint8_t> quantised(std::vector<float> pixels, int channels, bool premultiplied,
                               bool linear) {
  std::vector<uint8_t> bytes(pixels.size());
  for (size_t p = 0; p < pixels.size(); p += size_t(channels)) {
    const float alpha = channels == 4 ? clamped(pixels[p + 3]) : 1;
    for (size_t c = 0; c < size_t(channels); ++c) {
      float value = pixels[p + c];
      if (c < 3 && premultiplied && alpha > 0) value /= alpha;
      value = clamped(value);
      if (c < 3 && linear) value = srgb_from_linear(value);
      bytes[p + c] = uint8_t(std::lround(255 * value));
    }
  }
  return bytes;
}

/// The decoder's word on what it met, where that spoils pixels. Bytes too many before the end of
/// the image, which some cameras write, do not.
void refuse_damage(const path& file, OIIO::ImageInput& input, bool read) {
  const std::string seen = input.has_error() ? input.geterror() : "";
  const bool harmless = seen.find("extraneous bytes before marker 0xd9") != std::string::npos;
  if (read && (seen.empty() || harmless)) return;
  std::string line = seen.substr(0, seen.find('\n'));
  throw InputError(
      fmt::format("{}: cannot be decoded ({}); copy it again or take it out of the capture",
                  file.string(), line.empty() ? "no reason given" : line));
}

SourceImage read(const path& file, std::string& icc) {
  OIIO::ImageSpec wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(file.string(), &wishes);
  if (input == nullptr) {
    const std::string seen = OIIO::geterror();
    fail(file, fmt::format("cannot be opened as an image ({})", seen.substr(0, seen.find('\n'))));
  }
  const OIIO::ImageSpec& spec = input->spec();
  check_spec(file, spec);
  if (const auto* profile = spec.find_attribute("ICCProfile"))
    icc.assign(static_cast<const char*>(profile->data()), size_t(profile->datasize()));
  SourceImage source{{spec.width, spec.height, spec.nchannels, {}},
                     std::clamp(spec.get_int_attribute("Orientation", 1), 1, 8),
                     spec.format.is_floating_point()};
  const bool premultiplied =
      spec.nchannels == 4 && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
  const size_t count = size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels);
  if (premultiplied || source.tone_mapped) {
    std::vector<float> pixels(count);
    const bool whole =
        input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data());
    refuse_damage(file, *input, whole);
    source.image.data =
        quantised(std::move(pixels), spec.nchannels, premultiplied, source.tone_mapped);
  } else {
    source.image.data.resize(count);
    const bool whole =
        input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, source.image.data.data());
    refuse_damage(file, *input, whole);
  }
  return source;
}

}  // namespace
}  // namespace tessera

extern "C" void tessera_read_image(const std::filesystem::path& file, tessera::SourceImage& image,
                                   std::string& icc) {
  image = tessera::read(file, icc);
}
