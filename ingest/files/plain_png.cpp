// Chunks, checksums and filters from the PNG specification, second edition (W3C, 2003), clauses 5,
// 9 and 10; the compressed data are inflated in one call of libdeflate.
#include "ingest/files/plain_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

namespace tessera {
namespace {

constexpr uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr size_t kAroundData = 12;          // bytes of a chunk beside its data: length, type, CRC
constexpr size_t kHeaderBytes = 13;         // of the data of IHDR
constexpr size_t kMostAncillary = 1 << 20;  // bytes; libpng has a limit near 8 MB

/// A chunk in the file; the data are followed by their CRC.
struct Chunk {
  uint8_t* type = nullptr;  // four letters
  std::span<uint8_t> data;

  bool is(const char* name) const { return std::memcmp(type, name, 4) == 0; }
  bool has_right_crc() const {
    return libdeflate_crc32(0, type, 4 + data.size()) == big_endian_32(data.data() + data.size());
  }
  /// Whether libpng reads the same pixels without this chunk.
  bool can_be_skipped() const {
    const bool is_letters = std::all_of(type, type + 4, [](uint8_t byte) {
      return (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z');
    });
    const bool is_ancillary = (type[0] & 0x20) != 0;
    return is_letters && is_ancillary && !is("tRNS") && data.size() <= kMostAncillary;
  }
};

/// Takes the next chunk off `rest`; false where the file ends in it.
bool next_chunk(std::span<uint8_t>& rest, Chunk& chunk) {
  if (rest.size() < kAroundData) return false;
  const size_t length = big_endian_32(rest.data());
  if (length > rest.size() - kAroundData) return false;
  chunk = {rest.data() + 4, rest.subspan(8, length)};
  rest = rest.subspan(kAroundData + length);
  return true;
}

struct PlainFile {
  Image8 image;             // without pixels
  std::span<uint8_t> zlib;  // the data of all IDAT chunks
};

/// Size and channels of a plain IHDR; no channels where it is of another kind.
Image8 plain_header(const Chunk& chunk) {
  if (!chunk.is("IHDR") || chunk.data.size() != kHeaderBytes || !chunk.has_right_crc()) return {};
  const size_t width = big_endian_32(chunk.data.data());
  const size_t height = big_endian_32(chunk.data.data() + 4);
  if (width == 0 || height == 0 || width > kMaxPngSide || height > kMaxPngSide) return {};
  const std::span<uint8_t> kind = chunk.data.subspan(8);
  const bool is_plain = kind[0] == 8 && kind[2] == 0 && kind[3] == 0 && kind[4] == 0;
  const int channels = kind[1] == 0 ? 1 : kind[1] == 2 ? 3 : kind[1] == 6 ? 4 : 0;
  return {int(width), int(height), is_plain ? channels : 0, {}};
}

/// Walks the chunks up to IEND and moves the data of all IDAT together.
std::optional<PlainFile> parse_chunks(std::span<uint8_t> file) {
  if (file.size() < sizeof kSignature ||
      std::memcmp(file.data(), kSignature, sizeof kSignature) != 0)
    return std::nullopt;
  std::span<uint8_t> rest = file.subspan(sizeof kSignature);
  Chunk chunk;
  if (!next_chunk(rest, chunk)) return std::nullopt;
  PlainFile plain{plain_header(chunk), {}};
  if (plain.image.channels == 0) return std::nullopt;
  bool is_after_data = false;
  while (next_chunk(rest, chunk)) {
    if (chunk.is("IDAT")) {
      if (is_after_data || !chunk.has_right_crc()) return std::nullopt;
      if (plain.zlib.data() == nullptr) {
        plain.zlib = chunk.data;
        continue;
      }
      uint8_t* const end = plain.zlib.data() + plain.zlib.size();
      std::memmove(end, chunk.data.data(), chunk.data.size());
      plain.zlib = {plain.zlib.data(), plain.zlib.size() + chunk.data.size()};
    } else if (chunk.is("IEND")) {
      if (!chunk.data.empty() || !chunk.has_right_crc()) return std::nullopt;
      return plain;
    } else {
      if (!chunk.can_be_skipped()) return std::nullopt;
      is_after_data = plain.zlib.data() != nullptr;
    }
  }
  return std::nullopt;
}

/// Fills `out`; false where the data are damaged, or hold more or fewer bytes. A window smaller
/// than what is written is left to libpng, because libdeflate does not look at its size.
bool inflate_whole(std::span<const uint8_t> zlib, std::span<uint8_t> out) {
  if (zlib.empty()) return false;
  const size_t window = size_t{256} << (zlib[0] >> 4);
  if (window < std::min<size_t>(out.size(), 1 << 15)) return false;
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflater(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (inflater == nullptr) throw std::bad_alloc();
  size_t read = 0;
  return libdeflate_zlib_decompress_ex(inflater.get(), zlib.data(), zlib.size(), out.data(),
                                       out.size(), &read, nullptr) == LIBDEFLATE_SUCCESS &&
         read == zlib.size();
}

void undo_up(const uint8_t* __restrict coded, const uint8_t* __restrict above, size_t bytes,
             uint8_t* __restrict row) {
  for (size_t i = 0; i < bytes; ++i) row[i] = uint8_t(coded[i] + above[i]);
}

/// The values of one pixel, which filters of left neighbours take together.
using Lanes = int16_t __attribute__((vector_size(16)));

/// Reads four bytes, of which `store_pixel` writes those of the pixel back.
Lanes load_pixel(const uint8_t* bytes) {
  uint8_t __attribute__((vector_size(8))) lanes = {};
  std::memcpy(&lanes, bytes, 4);
  return __builtin_convertvector(lanes, Lanes);
}

template <int kPixel>
void store_pixel(Lanes pixel, uint8_t* to) {
  const auto lanes = __builtin_convertvector(pixel, uint8_t __attribute__((vector_size(8))));
  std::memcpy(to, &lanes, kPixel);
}

template <int kPixel>
void undo_sub(const uint8_t* coded, size_t bytes, uint8_t* row) {
  uint8_t left[kPixel] = {};
  for (size_t i = 0; i < bytes; i += kPixel)
    for (int c = 0; c < kPixel; ++c) row[i + c] = left[c] = uint8_t(coded[i + c] + left[c]);
}

template <int kPixel>
void undo_average(const uint8_t* coded, const uint8_t* above, size_t bytes, uint8_t* row) {
  Lanes left = {};
  for (size_t i = 0; i < bytes; i += kPixel) {
    left = (load_pixel(coded + i) + ((left + load_pixel(above + i)) >> 1)) & 255;
    store_pixel<kPixel>(left, row + i);
  }
}

Lanes magnitude(Lanes value) {
  return value > 0 ? value : -value;
}

/// To the neighbour nearest to left + above - corner; of equally near ones left, then above.
template <int kPixel>
void undo_paeth(const uint8_t* coded, const uint8_t* above, size_t bytes, uint8_t* row) {
  Lanes left = {}, corner = {};
  for (size_t i = 0; i < bytes; i += kPixel) {
    const Lanes up = load_pixel(above + i), from_left = up - corner, from_up = left - corner;
    const Lanes to_left = magnitude(from_left), to_up = magnitude(from_up);
    const Lanes to_corner = magnitude(from_left + from_up);
    Lanes nearest = to_up <= to_corner ? up : corner;
    nearest = ((to_left <= to_up) & (to_left <= to_corner)) ? left : nearest;
    left = (load_pixel(coded + i) + nearest) & 255;
    corner = up;
    store_pixel<kPixel>(left, row + i);
  }
}

/// Undoes the filters where the rows stand: `data` holds a filter byte and a row, `height` times,
/// and then the rows alone. False where a filter is unknown.
template <int kPixel>
bool undo_filters(size_t bytes, size_t height, uint8_t* data) {
  const std::vector<uint8_t> zeros(bytes + 3);  // 3: load_pixel() reads beyond the last pixel
  std::vector<uint8_t> coded(bytes + 3);
  const uint8_t* above = zeros.data();
  for (size_t y = 0; y < height; ++y) {
    const uint8_t* const stored = data + y * (bytes + 1);
    uint8_t* const row = data + y * bytes;
    const int filter = stored[0];
    if (filter == 0) {
      std::memmove(row, stored + 1, bytes);
    } else {
      std::memcpy(coded.data(), stored + 1, bytes);
      if (filter == 1)
        undo_sub<kPixel>(coded.data(), bytes, row);
      else if (filter == 2)
        undo_up(coded.data(), above, bytes, row);
      else if (filter == 3)
        undo_average<kPixel>(coded.data(), above, bytes, row);
      else if (filter == 4)
        undo_paeth<kPixel>(coded.data(), above, bytes, row);
      else
        return false;
    }
    above = row;
  }
  return true;
}

std::string big_endian_text(uint32_t number) {
  return {char(number >> 24), char(number >> 16), char(number >> 8), char(number)};
}

void add_chunk(const char* type, const std::string& data, std::string& file) {
  file += big_endian_text(uint32_t(data.size()));
  const size_t checked = file.size();
  file += type;
  file += data;
  file += big_endian_text(libdeflate_crc32(0, file.data() + checked, file.size() - checked));
}

}  // namespace

std::optional<Image8> decode_plain_png(std::span<uint8_t> file) {
  std::optional<PlainFile> plain = parse_chunks(file);
  if (!plain) return std::nullopt;
  Image8& image = plain->image;
  const size_t bytes = size_t(image.width) * size_t(image.channels), height = size_t(image.height);
  if (height * (bytes + 1) / kDeflateMaxRatio > plain->zlib.size()) return std::nullopt;
  image.data.resize(height * (bytes + 1));
  if (!inflate_whole(plain->zlib, image.data)) return std::nullopt;
  const auto undo = image.channels == 1   ? undo_filters<1>
                    : image.channels == 3 ? undo_filters<3>
                                          : undo_filters<4>;
  if (!undo(bytes, height, image.data.data())) return std::nullopt;
  image.data.resize(height * bytes);
  return std::move(image);
}

std::string encode_plain_png(const Image8& image) {
  constexpr int kLevel = 2;  // of 12: half of libpng's time at a size that is 1 % larger
  constexpr uint8_t kSub = 1;
  const auto channels = size_t(image.channels), stride = size_t(image.width) * channels;
  std::vector<uint8_t> rows((stride + 1) * size_t(image.height));
  for (size_t y = 0; y < size_t(image.height); ++y) {
    const uint8_t* const row = image.data.data() + y * stride;
    uint8_t* const filtered = rows.data() + y * (stride + 1);
    filtered[0] = kSub;
    std::copy_n(row, channels, filtered + 1);
    for (size_t x = channels; x < stride; ++x)
      filtered[1 + x] = uint8_t(row[x] - row[x - channels]);
  }
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> deflater(
      libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  if (deflater == nullptr) throw std::bad_alloc();
  std::string data(libdeflate_zlib_compress_bound(deflater.get(), rows.size()), '\0');
  data.resize(
      libdeflate_zlib_compress(deflater.get(), rows.data(), rows.size(), data.data(), data.size()));
  const auto colour_type = char(channels == 1 ? 0 : channels == 3 ? 2 : 6);
  std::string file(reinterpret_cast<const char*>(kSignature), sizeof kSignature);
  add_chunk("IHDR",
            big_endian_text(uint32_t(image.width)) + big_endian_text(uint32_t(image.height)) +
                std::string{8, colour_type, 0, 0, 0},
            file);
  add_chunk("IDAT", data, file);
  add_chunk("IEND", "", file);
  return file;
}

}  // namespace tessera
