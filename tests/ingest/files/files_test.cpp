// AtomicFile, PNG and NPY: round trips and every kind of invalid file.
#include "ingest/files/atomic_file.h"
#include "ingest/files/npy.h"
#include "ingest/files/png.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;

TEST(AtomicFile, AppearsOnCommitOnly) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.txt", "old");
  {
    AtomicFile file(folder / "a.txt");
    file.write("new");
    EXPECT_EQ(read_bytes(folder / "a.txt"), "old");
  }
  EXPECT_EQ(read_bytes(folder / "a.txt"), "old");
  write_text_file(folder / "a.txt", "new");
  EXPECT_EQ(read_bytes(folder / "a.txt"), "new");
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path()))
    ++files;
  EXPECT_EQ(files, 1) << "a temporary file was left behind";
}

TEST(AtomicFile, UnwritablePlaceIsNamed) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "x");
  expect_input_error([&] { write_text_file(folder / "file/below/a.txt", "x"); },
                     {"file/below", "ot a directory"});
  expect_input_error([&] { make_folder(folder / "file"); }, {"file", "ot a directory"});
}

// Bug put back: the result of fflush was ignored in commit(); seen to fail (no error).
TEST(AtomicFile, FullDiskIsNamed) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.bin");
  if (std::freopen("/dev/full", "wb", file.file()) == nullptr) GTEST_SKIP() << "no /dev/full";
  file.write("does not fit");
  try {
    file.commit();
    FAIL() << "no error";
  } catch (const WriteError& error) {
    EXPECT_NE(std::string(error.what()).find("a.bin"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos);
  }
}

TEST(AtomicFile, ReadingWhatIsNotThere) {
  const TemporaryFolder folder;
  expect_input_error([&] { read_text_file(folder / "none"); }, {"none", "No such file"});
  expect_input_error([&] { read_text_file(folder.path()); }, {"directory"});
}

TEST(Png, RoundTripOfEachKind) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3, 4}) {
    const Image8 image = patterned_image(13, 7, channels);
    write_png(folder / "a.png", image);
    const Image8 back = read_png(folder / "a.png");
    EXPECT_EQ(back.width, 13);
    EXPECT_EQ(back.height, 7);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.data, image.data);
    const Image8 size = read_png_size(folder / "a.png");
    EXPECT_EQ(size.width, 13);
    EXPECT_EQ(size.channels, channels);
    EXPECT_TRUE(size.data.empty());
  }
}

// Bug put back: png_error of the reader ignored at the end of the data (rest of the buffer left
// zero); seen to fail (no error at any truncation of the pixels).
TEST(Png, EveryTruncationIsAnErrorAndNoCrash) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", patterned_image(20, 20, 4));
  const std::string bytes = read_bytes(folder / "a.png");
  for (size_t length = 0; length < bytes.size(); length += 1 + length / 60) {
    write_bytes(folder / "cut.png", bytes.substr(0, length));
    expect_input_error([&] { read_png(folder / "cut.png"); }, {"cut.png"});
  }
}

TEST(Png, EveryFlippedByteIsAnErrorOrAImage) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", patterned_image(9, 9, 3));
  const std::string bytes = read_bytes(folder / "a.png");
  for (size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = char(damaged[i] ^ 0xff);
    write_bytes(folder / "bad.png", damaged);
    try {
      EXPECT_EQ(read_png(folder / "bad.png").data.size(), 9u * 9u * 3u);
    } catch (const InputError&) {
    }
  }
}

// Bug put back: check_header() not called; seen to fail (libpng's own words, no size named).
TEST(Png, SizesThatCannotBeAreRefusedBeforeMemoryIsTaken) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", patterned_image(4, 4, 3));
  const std::string bytes = read_bytes(folder / "a.png");
  std::string zero = bytes, huge = bytes;
  zero.replace(16, 4, std::string(4, '\0'));
  huge.replace(16, 8, std::string("\0\x0f\xff\xff\0\x0f\xff\xff", 8));
  write_bytes(folder / "zero.png", zero);
  write_bytes(folder / "huge.png", huge);
  write_bytes(folder / "text.png", "this is no image, whatever its name says");
  expect_input_error([&] { read_png(folder / "zero.png"); }, {"zero.png", "0x4", "1x1"});
  expect_input_error([&] { read_png(folder / "huge.png"); }, {"huge.png", "1048575x1048575"});
  expect_input_error([&] { read_png(folder / "text.png"); }, {"text.png", "not a PNG"});
}

TEST(Png, UnwritablePlaceIsNamed) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "x");
  expect_input_error([&] { write_png(folder / "file/a.png", patterned_image(2, 2, 3)); }, {"file"});
}

TEST(Npy, RoundTrip) {
  const TemporaryFolder folder;
  const Matrix matrix{2, 3, {1, -2.5, 3e-300, 4, 5, 6}};
  write_npy(folder / "a.npy", matrix);
  EXPECT_EQ(read_bytes(folder / "a.npy").size() % 64, 48u);  // header to a multiple of 64, 6 values
  const Matrix back = read_npy(folder / "a.npy");
  EXPECT_EQ(back.rows, 2);
  EXPECT_EQ(back.columns, 3);
  EXPECT_EQ(back.data, matrix.data);
}

TEST(Npy, FloatsInFortranOrder) {
  const TemporaryFolder folder;
  std::string header = "{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3), }";
  header.append(117 - header.size(), ' ') += '\n';
  std::string bytes = "\x93NUMPY" + std::string("\x01\x00\x76\x00", 4) + header;
  for (const float value : {1.f, 4.f, 2.f, 5.f, 3.f, 6.f})
    bytes.append(reinterpret_cast<const char*>(&value), 4);
  write_bytes(folder / "f.npy", bytes);
  EXPECT_EQ(read_npy(folder / "f.npy").data, (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST(Npy, BadFilesAreNamed) {
  const TemporaryFolder folder;
  write_npy(folder / "a.npy", {2, 17, std::vector<double>(34, 1.0)});
  const std::string bytes = read_bytes(folder / "a.npy");
  for (size_t length = 0; length < bytes.size(); length += 5) {
    write_bytes(folder / "cut.npy", bytes.substr(0, length));
    expect_input_error([&] { read_npy(folder / "cut.npy"); }, {"cut.npy"});
  }
  std::string huge = bytes;
  huge.replace(huge.find("(2, 17)"), 7, "(2000000000, 17)");
  write_bytes(folder / "huge.npy", huge);
  expect_input_error([&] { read_npy(folder / "huge.npy"); }, {"2000000000", "truncated"});
  std::string other = bytes;
  other.replace(other.find("<f8"), 3, "<c8");
  write_bytes(folder / "other.npy", other);
  expect_input_error([&] { read_npy(folder / "other.npy"); }, {"<c8"});
}

// Finds a mark that is left, the order of bytes, lost surrogates, and a lone return that joins
// lines.
TEST(PlainText, IsTheSameWhateverSystemWroteIt) {
  const std::string text = "a \xc3\xa9\n\xe2\x82\xac \xf0\x9f\x98\x80\n";  // é, €, a face
  EXPECT_EQ(plain_text(text), text);
  EXPECT_EQ(plain_text("\xef\xbb\xbf" + text), text);
  EXPECT_EQ(plain_text("a \xc3\xa9\r\n\xe2\x82\xac \xf0\x9f\x98\x80\r"), text);
  const std::u16string wide = u"a \u00e9\r\n\u20ac \U0001f600\n";
  std::string little = "\xff\xfe", big = "\xfe\xff";
  for (const char16_t unit : wide) {
    little += {char(unit & 0xff), char(unit >> 8)};
    big += {char(unit >> 8), char(unit & 0xff)};
  }
  EXPECT_EQ(plain_text(little), text);
  EXPECT_EQ(plain_text(big), text);
  EXPECT_EQ(plain_text(""), "");
  EXPECT_EQ(plain_text("\xff\xfe"), "");
}

}  // namespace
}  // namespace tessera
