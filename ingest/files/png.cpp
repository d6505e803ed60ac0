// Uses the row interface of libpng for what plain_png.h does not decode; `guarded` converts its
// errors (longjmp) to InputError. The chunks gAMA, sRGB and iCCP are ignored: values are used as
// stored.
#include "ingest/files/png.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "ingest/files/plain_png.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr size_t kMostBytesAtOnce = size_t{1} << 30;  // libpng reads longer files piece by piece

struct Failure {
  char text[200] = "unknown libpng error";
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  auto* failure = static_cast<Failure*>(png_get_error_ptr(png));
  std::strncpy(failure->text, text, sizeof failure->text - 1);
  std::longjmp(png_jmpbuf(png), 1);
}

void on_warning(png_structp, png_const_charp) {}

/// Runs `body`, which must own nothing (libpng jumps out of it). False when libpng gave up.
template <class Body>
bool guarded(png_structp png, const Body& body) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  body();
  return true;
}

void read_bytes(png_structp png, png_bytep to, size_t count) {
  auto* file = static_cast<std::FILE*>(png_get_io_ptr(png));
  if (std::fread(to, 1, count, file) == count) return;
  png_error(png, std::ferror(file) != 0 ? std::strerror(errno) : "the file ends early, truncated");
}

struct ReadState {
  Failure failure;
  png_structp png = nullptr;
  png_infop info = nullptr;
  ReadState() {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, on_error, on_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  ~ReadState() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void refuse_image(const std::filesystem::path& path, const std::string& seen) {
  throw InputError(fmt::format("{}: {}; copy or render this image again", path.string(), seen));
}

/// Looks at signature and IHDR by hand, so nothing is allocated for a size the file cannot hold.
void check_header(const std::filesystem::path& path, std::FILE* file) {
  uint8_t start[33] = {};  // signature, IHDR
  const size_t count = std::fread(start, 1, sizeof start, file);
  if (std::ferror(file) != 0)
    refuse_image(path, fmt::format("cannot be read ({})", std::strerror(errno)));
  if (count == 0) refuse_image(path, "is an empty file, expected a PNG");
  if (png_sig_cmp(start, 0, std::min<size_t>(8, count)) != 0) refuse_image(path, "is not a PNG");
  if (count < sizeof start) refuse_image(path, fmt::format("PNG truncated after {} bytes", count));
  const int64_t width = big_endian_32(start + 16), height = big_endian_32(start + 20);
  if (width == 0 || height == 0)
    refuse_image(path, fmt::format("has size {}x{}, expected at least 1x1 pixel", width, height));
  if (width > kMaxPngSide || height > kMaxPngSide)
    refuse_image(path, fmt::format("states a size of {}x{}, more than {} a side", width, height,
                                   kMaxPngSide));
  constexpr int kChannelsOfColourType[7] = {1, 0, 3, 1, 2, 0, 4};
  const int depth = start[24], colour_type = start[25];
  if (depth > 16 || colour_type > 6) refuse_image(path, "has a damaged PNG header");
  const int64_t pixel_bits = depth * kChannelsOfColourType[colour_type];
  const int64_t least_bytes = (width * pixel_bits + 7) / 8 * height;
  const auto file_bytes = int64_t(std::filesystem::file_size(path));
  if (least_bytes / kDeflateMaxRatio > file_bytes)
    refuse_image(path, fmt::format("states {}x{} pixels, which {} bytes cannot hold (truncated)",
                                   width, height, file_bytes));
  std::rewind(file);
}

/// Asks libpng for 8-bit grey, RGB or RGBA whatever is stored.
void set_transforms(png_structp png, png_infop info) {
  png_set_scale_16(png);
  png_set_expand(png);  // palettes, 1/2/4-bit grey, tRNS → alpha
  const bool has_alpha = (png_get_color_type(png, info) & PNG_COLOR_MASK_ALPHA) != 0 ||
                         png_get_valid(png, info, PNG_INFO_tRNS) != 0;
  if (has_alpha) png_set_gray_to_rgb(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
}

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// A PNG file whose header is checked, at its beginning.
File open_png(const std::filesystem::path& path) {
  File file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (file == nullptr)
    refuse_image(path, fmt::format("cannot be opened ({})", std::strerror(errno)));
  check_header(path, file.get());
  return file;
}

/// The pixels where the file is plain; else nothing, and the file is at its beginning again.
std::optional<Image8> read_plain(const std::filesystem::path& path, std::FILE* file) {
  const auto size = size_t(std::filesystem::file_size(path));
  if (size > kMostBytesAtOnce) return std::nullopt;
  std::vector<uint8_t> bytes(size);
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file));
  std::rewind(file);
  return decode_plain_png(bytes);
}

/// Reads up to the pixels; the result has its size and no data.
Image8 read_start(const std::filesystem::path& path, ReadState& state, std::FILE* file) {
  if (state.info == nullptr) throw std::bad_alloc();
  const bool read = guarded(state.png, [&] {
    png_set_user_limits(state.png, kMaxPngSide, kMaxPngSide);
    png_set_read_fn(state.png, file, read_bytes);
    png_read_info(state.png, state.info);
    set_transforms(state.png, state.info);
  });
  if (!read) refuse_image(path, fmt::format("unreadable PNG header ({})", state.failure.text));
  return {int(png_get_image_width(state.png, state.info)),
          int(png_get_image_height(state.png, state.info)),
          png_get_channels(state.png, state.info),
          {}};
}

}  // namespace

Image8 read_png_size(const std::filesystem::path& path) {
  const File file = open_png(path);
  ReadState state;
  return read_start(path, state, file.get());
}

Image8 read_png(const std::filesystem::path& path) {
  const File file = open_png(path);
  if (std::optional<Image8> plain = read_plain(path, file.get())) return *std::move(plain);
  ReadState state;
  Image8 image = read_start(path, state, file.get());
  const size_t stride = png_get_rowbytes(state.png, state.info);
  check(stride == size_t(image.width) * size_t(image.channels), "PNG row is not 8 bit");
  image.data.resize(stride * size_t(image.height));
  std::vector<png_bytep> rows(size_t(image.height));
  for (size_t y = 0; y < rows.size(); ++y) rows[y] = image.data.data() + y * stride;
  const bool read = guarded(state.png, [&] {
    png_read_image(state.png, rows.data());
    png_read_end(state.png, nullptr);
  });
  if (!read) refuse_image(path, fmt::format("unreadable PNG ({})", state.failure.text));
  return image;
}

void write_png(const std::filesystem::path& path, const Image8& image) {
  const size_t stride = size_t(image.width) * size_t(image.channels);
  check(image.width > 0 && image.height > 0, "write_png of an empty image");
  check(image.channels == 1 || image.channels == 3 || image.channels == 4, "write_png channels");
  check(image.data.size() == stride * size_t(image.height), "write_png data size");
  AtomicFile file(path);
  file.write(encode_plain_png(image));
  file.commit();
}

}  // namespace tessera
