// Compares decode_plain_png() with libpng: equal pixels, and nothing for files that libpng refuses.
#include "ingest/files/plain_png.h"

#include <png.h>
#include <zlib.h>

#include <random>

#include "ingest/files/png.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;

std::string big_endian(uint32_t value) {
  return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

std::string png_chunk(const std::string& type, const std::string& data, uint32_t wrong_crc = 0) {
  const std::string covered = type + data;
  const auto crc =
      uint32_t(crc32(0, reinterpret_cast<const Bytef*>(covered.data()), uInt(covered.size())));
  return big_endian(uint32_t(data.size())) + covered + big_endian(crc ^ wrong_crc);
}

const std::string kSignature = "\x89PNG\r\n\x1a\n";
const std::string kEnd = png_chunk("IEND", "");

std::string header_data(uint32_t width, uint32_t height, int depth, int colour,
                        int interlaced = 0) {
  return big_endian(width) + big_endian(height) +
         std::string{char(depth), char(colour), 0, 0, char(interlaced)};
}

std::string zlib_stream(const std::string& bytes) {
  std::string out(compressBound(bytes.size()), '\0');
  uLongf size = out.size();
  compress2(reinterpret_cast<Bytef*>(out.data()), &size,
            reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), 6);
  return out.substr(0, size);
}

std::optional<Image8> decoded_plain(std::string file) {
  return decode_plain_png({reinterpret_cast<uint8_t*>(file.data()), file.size()});
}

/// Few values, so that many neighbours are equally near, or all of them.
Image8 random_image(int width, int height, int channels, int most) {
  std::mt19937 random(uint32_t(width + 7 * height + 31 * channels + most));
  Image8 image{width, height, channels, {}};
  image.data.resize(size_t(width) * size_t(height) * size_t(channels));
  for (uint8_t& value : image.data)
    value = uint8_t(random() % uint32_t(most + 1) * 255 / uint32_t(most));
  return image;
}

void append_bytes(png_structp png, png_bytep bytes, size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(bytes), count);
}

/// Written by libpng with these filters and IDAT chunks of at most that many bytes.
std::string written_by_libpng(const Image8& image, int filters, size_t chunk_bytes) {
  std::string file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &file, append_bytes, nullptr);
  png_set_compression_buffer_size(png, chunk_bytes);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, filters);
  png_set_IHDR(png, info, png_uint_32(image.width), png_uint_32(image.height), 8,
               image.channels == 1   ? PNG_COLOR_TYPE_GRAY
               : image.channels == 3 ? PNG_COLOR_TYPE_RGB
                                     : PNG_COLOR_TYPE_RGB_ALPHA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const size_t stride = size_t(image.width) * size_t(image.channels);
  for (size_t y = 0; y < size_t(image.height); ++y)
    png_write_row(png, image.data.data() + y * stride);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return file;
}

/// The same image of a kind that is left to libpng: a palette is suggested behind the header.
std::string with_palette(const std::string& file) {
  constexpr size_t kHeaderEnd = 33;
  return file.substr(0, kHeaderEnd) + png_chunk("PLTE", "abc") + file.substr(kHeaderEnd);
}

// Bug put back: Paeth takes corner before above where both are equally near; seen to fail.
TEST(PlainPng, SamePixelsWithEachFilter) {
  const TemporaryFolder folder;
  const int sizes[][2] = {{1, 1}, {1, 7}, {7, 1}, {5, 3}, {37, 29}, {640, 36}};
  for (const auto& [width, height] : sizes)
    for (const int channels : {1, 3, 4})
      for (const int filter : {PNG_FILTER_NONE, PNG_FILTER_SUB, PNG_FILTER_UP, PNG_FILTER_AVG,
                               PNG_FILTER_PAETH, PNG_ALL_FILTERS})
        for (const int most : {3, 255}) {
          const Image8 image = random_image(width, height, channels, most);
          const std::string file = written_by_libpng(image, filter, width == 640 ? 8192 : 40);
          const std::optional<Image8> plain = decoded_plain(file);
          ASSERT_TRUE(plain) << width << "x" << height << "x" << channels << " " << filter;
          EXPECT_EQ(plain->width, width);
          EXPECT_EQ(plain->height, height);
          EXPECT_EQ(plain->channels, channels);
          ASSERT_EQ(plain->data, image.data)
              << width << "x" << height << "x" << channels << " " << filter;
          EXPECT_FALSE(decoded_plain(with_palette(file)));
          write_bytes(folder / "palette.png", with_palette(file));
          EXPECT_EQ(read_png(folder / "palette.png").data, image.data);
        }
}

constexpr uint32_t kPlainWidth = 4, kPlainHeight = 3;
const std::string kHeader =
    png_chunk("IHDR", header_data(kPlainWidth, kPlainHeight, 8, PNG_COLOR_TYPE_RGB));

/// Rows of the filter None and of values that grow; `filter` is that of the second row.
std::string rows_of_plain(int filter = 0) {
  std::string bytes;
  for (uint32_t y = 0; y < kPlainHeight; ++y) {
    bytes += char(y == 1 ? filter : 0);
    for (uint32_t x = 0; x < 3 * kPlainWidth; ++x) bytes += char(20 * y + x);
  }
  return bytes;
}

std::vector<uint8_t> pixels_of_plain() {
  std::vector<uint8_t> values;
  for (uint32_t y = 0; y < kPlainHeight; ++y)
    for (uint32_t x = 0; x < 3 * kPlainWidth; ++x) values.push_back(uint8_t(20 * y + x));
  return values;
}

std::string plain_file(const std::string& data_chunks) {
  return kSignature + kHeader + data_chunks + kEnd;
}

TEST(PlainPng, SkipsWhatDoesNotChangePixels) {
  const std::string stream = zlib_stream(rows_of_plain());
  const std::string text = png_chunk("tEXt", std::string("Title\0a", 7)),
                    gamma = png_chunk("gAMA", big_endian(9));
  const std::string file = kSignature + kHeader + gamma + text + png_chunk("IDAT", "") +
                           png_chunk("IDAT", stream.substr(0, 5)) +
                           png_chunk("IDAT", stream.substr(5)) + text + kEnd +
                           "what follows the end";
  const std::optional<Image8> plain = decoded_plain(file);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->data, pixels_of_plain());
}

struct PngDamage {
  std::string name, file, message;  // "": libpng only warns, and gives the pixels
};
constexpr const char* kByVersion = "one or the other by the version of libpng";

std::vector<PngDamage> damaged_files() {
  const std::string stream = zlib_stream(rows_of_plain()), data = png_chunk("IDAT", stream);
  const std::string whole = plain_file(data), text = png_chunk("tEXt", std::string("Title\0a", 7));
  std::string wrong_adler = stream, no_zlib = stream;
  wrong_adler.back() = char(wrong_adler.back() ^ 1);
  no_zlib[0] = 0;
  return {
      {"cut_data", plain_file(png_chunk("IDAT", stream.substr(0, 10))),
       "unreadable PNG (Not enough image data)"},
      {"data_crc", plain_file(png_chunk("IDAT", stream, 1)), "unreadable PNG (IDAT: CRC error)"},
      {"header_crc", kSignature + png_chunk("IHDR", header_data(4, 3, 8, 2), 1) + data + kEnd,
       "unreadable PNG header (IHDR: CRC error)"},
      {"end_crc", kSignature + kHeader + data + png_chunk("IEND", "", 1), kByVersion},
      {"adler", plain_file(png_chunk("IDAT", wrong_adler)),
       "unreadable PNG (IDAT: incorrect data check)"},
      {"no_zlib", plain_file(png_chunk("IDAT", no_zlib)),
       "unreadable PNG (IDAT: incorrect header check)"},
      {"short", plain_file(png_chunk("IDAT", zlib_stream(rows_of_plain().substr(0, 30)))),
       "unreadable PNG (Not enough image data)"},
      {"long", plain_file(png_chunk("IDAT", zlib_stream(rows_of_plain() + "more"))), ""},
      {"behind_data", plain_file(png_chunk("IDAT", stream + "more")), ""},
      {"filter", plain_file(png_chunk("IDAT", zlib_stream(rows_of_plain(5)))),
       "unreadable PNG (bad adaptive filter value)"},
      {"no_end", kSignature + kHeader + data, "unreadable PNG (the file ends early, truncated)"},
      {"in_end", whole.substr(0, whole.size() - 1),
       "unreadable PNG (the file ends early, truncated)"},
      {"in_data", whole.substr(0, whole.size() - 20),
       "unreadable PNG (the file ends early, truncated)"},
      {"no_data", kSignature + kHeader + kEnd, "unreadable PNG header (IEND: out of place)"},
      {"critical", kSignature + kHeader + png_chunk("ABCD", "") + data + kEnd,
       "unreadable PNG header (ABCD: unhandled critical chunk)"},
      {"no_letters", kSignature + kHeader + png_chunk("a1CD", "") + data + kEnd,
       "unreadable PNG header (a[31]CD: "},
      {"text_within",
       plain_file(png_chunk("IDAT", stream.substr(0, 9)) + text +
                  png_chunk("IDAT", stream.substr(9))),
       "unreadable PNG (Not enough image data)"},
      {"filter_method",
       kSignature + png_chunk("IHDR", header_data(4, 3, 8, 2).replace(11, 1, "\1")) + data + kEnd,
       "unreadable PNG header (Invalid IHDR data)"},
  };
}

// The messages are those of a reader that has libpng alone.
// Bug put back: the CRC of IDAT not checked; seen to fail (data_crc is decoded).
TEST(PlainPng, LeavesDamageToLibpng) {
  const TemporaryFolder folder;
  for (const PngDamage& damage : damaged_files()) {
    SCOPED_TRACE(damage.name);
    EXPECT_FALSE(decoded_plain(damage.file));
    const std::filesystem::path path = folder / (damage.name + ".png");
    write_bytes(path, damage.file);
    if (damage.message == kByVersion) continue;
    if (damage.message.empty())
      EXPECT_EQ(read_png(path).data, pixels_of_plain());
    else
      expect_input_error([&] { read_png(path); }, {path.string(), damage.message});
  }
}

TEST(PlainPng, EveryFlippedByteIsLeftToLibpng) {
  const std::string file = written_by_libpng(random_image(9, 6, 3, 3), PNG_ALL_FILTERS, 40);
  ASSERT_TRUE(decoded_plain(file));
  for (size_t i = 0; i < file.size(); ++i)
    for (const int flip : {1, 0x20, 0xff}) {
      std::string damaged = file;
      damaged[i] = char(damaged[i] ^ flip);
      EXPECT_FALSE(decoded_plain(damaged)) << i;
    }
}

// libdeflate does not look at the size of the window; zlib does.
TEST(PlainPng, LeavesSmallWindowsToLibpng) {
  std::string small = written_by_libpng(random_image(64, 36, 3, 3), PNG_FILTER_NONE, 8192);
  ASSERT_TRUE(decoded_plain(small));
  const size_t data = small.find("IDAT"), length = small.size() - kEnd.size() - 8 - data;
  small.replace(data + 4, 2, "\x08\x1d");  // of 256 bytes
  EXPECT_FALSE(decoded_plain(small.substr(0, data - 4) +
                             png_chunk("IDAT", small.substr(data + 4, length)) + kEnd));
}

/// Reads a file of another kind, which libpng turns into 8 bits.
void expect_libpng(const std::string& file, int channels, const std::vector<uint8_t>& values) {
  const TemporaryFolder folder;
  EXPECT_FALSE(decoded_plain(file));
  write_bytes(folder / "a.png", file);
  const Image8 image = read_png(folder / "a.png");
  EXPECT_EQ(image.channels, channels);
  EXPECT_EQ(image.data, values);
}

std::string file_of_kind(int depth, int colour, int interlaced, const std::string& before,
                         const std::string& stored) {
  return kSignature + png_chunk("IHDR", header_data(2, 1, depth, colour, interlaced)) + before +
         png_chunk("IDAT", zlib_stream(stored)) + kEnd;
}

TEST(PlainPng, LeavesOtherKindsToLibpng) {
  using namespace std::string_literals;
  const std::string none(1, '\0'), palette = png_chunk("PLTE", "abcdef");
  expect_libpng(file_of_kind(16, PNG_COLOR_TYPE_GRAY, 0, "", none + "\xff\xff\x12\x34"), 1,
                {255, 18});
  expect_libpng(file_of_kind(8, PNG_COLOR_TYPE_PALETTE, 0, palette, none + "\x01\x00"s), 3,
                {'d', 'e', 'f', 'a', 'b', 'c'});
  expect_libpng(file_of_kind(1, PNG_COLOR_TYPE_GRAY, 0, "", none + "\x40"), 1, {0, 255});
  expect_libpng(file_of_kind(8, PNG_COLOR_TYPE_GRAY_ALPHA, 0, "", none + "\x05\x06\x07\x08"), 4,
                {5, 5, 5, 6, 7, 7, 7, 8});
  expect_libpng(file_of_kind(8, PNG_COLOR_TYPE_GRAY, 1, "", none + "\x05" + none + "\x06"), 1,
                {5, 6});
  expect_libpng(file_of_kind(8, PNG_COLOR_TYPE_RGB, 0, png_chunk("tRNS", "\0\1\0\2\0\3"s),
                             none + "\x01\x02\x03\x04\x05\x06"),
                4, {1, 2, 3, 0, 4, 5, 6, 255});
}

}  // namespace
}  // namespace tessera
