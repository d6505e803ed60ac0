// Reads PNG through ingest/files/png.h and other formats through OpenImageIO. Integers are sRGB
// unless a profile says otherwise.
#include "ingest/images/image_source.h"

#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "ingest/images/colour_profile.h"
#include "ingest/images/openimageio_module.h"
#include "ingest/poses/intrinsics.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

using std::filesystem::path;

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
    std::string icc;
    source = read_through_openimageio(file, icc);
    if (!icc.empty() && !colour.profile && colour.unknown.empty()) colour = colour_of_icc(icc);
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
