// What: PNG through libpng, everything else through OpenImageIO.
// Not: EXIF rotation: poses belong to the pixels as stored.
#include "ingest/media/image_source.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& seen) {
  throw InputError(
      fmt::format("{}: {}; convert this picture to 8-bit sRGB PNG", path.string(), seen));
}

/// libjpeg fills what is missing with grey and only warns. Inside a scan 0xFF is never followed by
/// a marker, so a whole file has its end-of-image marker behind the last start-of-scan.
void refuse_truncated_jpeg(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  if (!bytes.starts_with("\xff\xd8")) return;  // not a JPEG
  const size_t scan = bytes.rfind("\xff\xda"), end = bytes.rfind("\xff\xd9");
  if (scan != std::string::npos && end != std::string::npos && end > scan) return;
  throw InputError(fmt::format(
      "{}: truncated JPEG, it has no end-of-image marker; copy it again or take it out of the "
      "capture",
      path.string()));
}

void undo_premultiplied_alpha(Image8& image) {
  for (size_t p = 0; p < image.data.size(); p += 4) {
    const int alpha = image.data[p + 3];
    for (size_t c = 0; alpha > 0 && c < 3; ++c)
      image.data[p + c] = uint8_t(std::min(255, (image.data[p + c] * 255 + alpha / 2) / alpha));
  }
}

}  // namespace

Image8 read_picture(const std::filesystem::path& path) {
  if (path.extension() == ".png" || path.extension() == ".PNG") return read_png(path);
  if (std::filesystem::is_regular_file(path)) refuse_truncated_jpeg(path);
  OIIO::ImageSpec wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path.string(), &wishes);
  if (input == nullptr) fail(path, fmt::format("cannot be opened ({})", OIIO::geterror()));
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.format.is_floating_point()) fail(path, "has floating-point pixels, taken for linear");
  if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1)
    fail(path, fmt::format("has size {}x{}x{}", spec.width, spec.height, spec.depth));
  if (spec.nchannels != 1 && spec.nchannels != 3 && spec.nchannels != 4)
    fail(path, fmt::format("has {} channels", spec.nchannels));
  Image8 image{spec.width, spec.height, spec.nchannels, {}};
  image.data.resize(size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels));
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, image.data.data()))
    fail(path, fmt::format("cannot be decoded ({})", input->geterror()));
  if (image.channels == 4 && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0 &&
      spec.alpha_channel == 3)
    undo_premultiplied_alpha(image);
  return image;
}

}  // namespace tessera
