// Reads PNG through ingest/files/png.h and other formats through OpenImageIO. Integers are sRGB
// unless a profile says otherwise, floats are linear with sRGB primaries. Source of the transfer
// curve: IEC 61966-2-1.
#include "ingest/images/image_source.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "ingest/images/colour_profile.h"
#include "ingest/poses/intrinsics.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

using std::filesystem::path;

[[noreturn]] void fail(const path& file, const std::string& seen) {
  throw InputError(
      fmt::format("{}: {}; convert this image to 8-bit sRGB PNG", file.string(), seen));
}

/// Whether the bytes are a JPEG image with its end, by its markers: segments have lengths, and
/// within a scan 0xFF is followed by 0 or a restart marker. What follows the end is no concern.
bool is_whole_jpeg(const std::string& bytes) {
  const auto byte = [&](size_t i) { return uint8_t(bytes[i]); };
  for (size_t place = 2; place + 1 < bytes.size();) {
    if (byte(place) != 0xff) return false;
    const uint8_t marker = byte(place + 1);
    if (marker == 0xd9) return true;
    if (marker == 0xff) {  // fill
      ++place;
      continue;
    }
    const bool is_alone = marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    if (!is_alone && place + 3 >= bytes.size()) return false;
    place += is_alone ? 2 : 2 + size_t(256) * byte(place + 2) + byte(place + 3);
    if (marker != 0xda) continue;
    const auto is_in_scan = [&](size_t i) {
      return byte(i) != 0xff || byte(i + 1) == 0 || (byte(i + 1) >= 0xd0 && byte(i + 1) <= 0xd7);
    };
    while (place + 1 < bytes.size() && is_in_scan(place)) ++place;
  }
  return false;
}

/// libjpeg fills what is missing with grey and only warns.
void refuse_truncated_jpeg(const path& file, const std::string& bytes) {
  if (!bytes.starts_with("\xff\xd8") || is_whole_jpeg(bytes)) return;
  throw InputError(fmt::format(
      "{}: truncated JPEG, it has no end-of-image marker; copy it again or take it out of the "
      "capture",
      file.string()));
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

/// `colour` becomes that of a profile in other formats than PNG and JPEG.
SourceImage read_through_oiio(const path& file, StatedColour& colour) {
  OIIO::ImageSpec wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(file.string(), &wishes);
  if (input == nullptr) {
    const std::string seen = OIIO::geterror();
    fail(file, fmt::format("cannot be opened as an image ({})", seen.substr(0, seen.find('\n'))));
  }
  const OIIO::ImageSpec& spec = input->spec();
  check_spec(file, spec);
  if (const auto* icc = spec.find_attribute("ICCProfile");
      icc != nullptr && !colour.profile && colour.unknown.empty())
    colour = colour_of_icc({static_cast<const char*>(icc->data()), size_t(icc->datasize())});
  SourceImage source{{spec.width, spec.height, spec.nchannels, {}},
                     std::clamp(spec.get_int_attribute("Orientation", 1), 1, 8),
                     spec.format.is_floating_point()};
  const bool premultiplied =
      spec.nchannels == 4 && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
  const size_t count = size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels);
  if (premultiplied || source.tone_mapped) {
    std::vector<float> pixels(count);
    const bool read =
        input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data());
    refuse_damage(file, *input, read);
    source.image.data =
        quantised(std::move(pixels), spec.nchannels, premultiplied, source.tone_mapped);
  } else {
    source.image.data.resize(count);
    const bool read =
        input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, source.image.data.data());
    refuse_damage(file, *input, read);
  }
  return source;
}

}  // namespace

SourceImage read_source_image(const path& file) {
  const std::string bytes = read_text_file(file);
  if (bytes.empty())
    throw InputError(fmt::format(
        "{}: is an empty file, expected an image; copy it again or take it out of the capture",
        file.string()));
  const bool is_png =
      bytes.starts_with("\x89PNG") || lower_case(file.extension().string()) == ".png";
  StatedColour colour = colour_of_file(bytes);
  SourceImage source;
  if (is_png && !bytes.starts_with("\xff\xd8")) {  // a JPEG may be called .png
    source.image = read_png(file);
  } else {
    refuse_truncated_jpeg(file, bytes);
    source = read_through_oiio(file, colour);
  }
  if (colour.profile && !source.tone_mapped) {
    convert_to_srgb(*colour.profile, source.image);
    source.converted = colour.profile->name;
  }
  source.unconverted = colour.unknown;
  return source;
}

Image8 read_image(const path& file) {
  return read_source_image(file).image;
}

Image8 turned_upright(const Image8& stored, int orientation) {
  check(orientation >= 1 && orientation <= 8, "EXIF orientation");
  const bool sides_swapped = orientation >= 5;
  const int w = stored.width, h = stored.height;
  Image8 upright{sides_swapped ? h : w, sides_swapped ? w : h, stored.channels, {}};
  upright.data.reserve(stored.data.size());
  // The tag is the position of row 0 and column 0 of the stored image in the upright one.
  const bool from_right =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  for (int y = 0; y < upright.height; ++y)
    for (int x = 0; x < upright.width; ++x) {
      int column = sides_swapped ? y : x, row = sides_swapped ? x : y;
      if (from_right) column = w - 1 - column;
      if (from_below) row = h - 1 - row;
      const auto scalar = (ptrdiff_t(row) * w + column) * stored.channels;
      upright.data.insert(upright.data.end(), stored.data.begin() + scalar,
                          stored.data.begin() + scalar + stored.channels);
    }
  return upright;
}

Image8 image_as_posed(SourceImage source, int width, int height, bool& doubtful) {
  if (source.orientation == 1) return std::move(source.image);
  const int w = source.image.width, h = source.image.height;
  const bool sides_swapped = source.orientation >= 5;
  const bool as_stored = same_shape(width, height, w, h);
  const bool upright = sides_swapped ? same_shape(width, height, h, w) : as_stored;
  if (upright && !as_stored) return turned_upright(source.image, source.orientation);
  doubtful = doubtful || upright;
  return std::move(source.image);
}

}  // namespace tessera
