// PLY in its three encodings, with lists, and every kind of invalid file.
#include "ingest/files/ply.h"

#include <algorithm>

#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;

PlyFile two_elements() {
  PlyFile file;
  file.comments = {"made by a test"};
  file.elements.push_back({"vertex",
                           2,
                           {{"x", PlyType::kFloat32, {0.5, -1.25}},
                            {"red", PlyType::kUint8, {0, 255}},
                            {"id", PlyType::kInt32, {-2147483648.0, 7}}}});
  file.elements.push_back({"extra", 1, {{"d", PlyType::kFloat64, {1e300}}}});
  return file;
}

void expect_equal(const PlyFile& one, const PlyFile& other) {
  ASSERT_EQ(one.elements.size(), other.elements.size());
  for (size_t e = 0; e < one.elements.size(); ++e) {
    EXPECT_EQ(one.elements[e].name, other.elements[e].name);
    ASSERT_EQ(one.elements[e].columns.size(), other.elements[e].columns.size());
    for (size_t c = 0; c < one.elements[e].columns.size(); ++c) {
      EXPECT_EQ(one.elements[e].columns[c].name, other.elements[e].columns[c].name);
      EXPECT_EQ(one.elements[e].columns[c].type, other.elements[e].columns[c].type);
      EXPECT_EQ(one.elements[e].columns[c].values, other.elements[e].columns[c].values);
    }
  }
}

TEST(Ply, RoundTrip) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", two_elements());
  const PlyFile back = read_ply(folder / "a.ply");
  expect_equal(two_elements(), back);
  EXPECT_EQ(back.comments, two_elements().comments);
  EXPECT_NE(back.find("vertex")->find("red"), nullptr);
  EXPECT_EQ(back.find("vertex")->find("blue"), nullptr);
  EXPECT_EQ(back.find("face"), nullptr);
}

// Bug put back: values of big-endian files taken without swapping; seen to fail.
TEST(Ply, AsciiAndBigEndianHoldTheSame) {
  const TemporaryFolder folder;
  const std::string columns =
      "comment made by a test\nelement vertex 2\nproperty float x\nproperty uchar red\n"
      "property int id\nelement extra 1\nproperty double d\nend_header\n";
  write_bytes(folder / "a.ply", "ply\r\nformat ascii 1.0\r\n" + columns +
                                    "0.5 0 -2147483648\n  -1.25\t255 +7\n\n1e300");
  expect_equal(two_elements(), read_ply(folder / "a.ply"));
  std::string body;
  const auto put = [&](auto value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    for (size_t i = sizeof value; i-- > 0;) body += bytes[i];
  };
  put(0.5f);
  put(uint8_t(0));
  put(int32_t(-2147483648));
  put(-1.25f);
  put(uint8_t(255));
  put(int32_t(7));
  put(1e300);
  write_bytes(folder / "b.ply", "ply\nformat binary_big_endian 1.0\n" + columns + body);
  expect_equal(two_elements(), read_ply(folder / "b.ply"));
}

TEST(Ply, ListsArePassedOver) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.ply",
              "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\n"
              "property uchar flag\nelement vertex 1\nproperty float x\nend_header\n"
              "3 0 1 2 9\n0 8\n4.5\n");
  const PlyFile file = read_ply(folder / "a.ply");
  EXPECT_EQ(file.find("face")->find("flag")->values, (std::vector<double>{9, 8}));
  EXPECT_EQ(file.find("vertex")->find("x")->values, (std::vector<double>{4.5}));
}

// Bug put back: rows not compared with the bytes there are; seen to fail (std::length_error).
TEST(Ply, PromisedRowsAreCheckedBeforeMemoryIsTaken) {
  const TemporaryFolder folder;
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    write_bytes(folder / "huge.ply", std::string("ply\nformat ") + format +
                                         " 1.0\nelement vertex 9000000000000000000\n"
                                         "property float x\nend_header\n1 2 3 4");
    expect_input_error([&] { read_ply(folder / "huge.ply"); }, {"huge.ply", "9000000000000000000"});
  }
}

TEST(Ply, EveryTruncationIsAnError) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", two_elements());
  const std::string bytes = read_bytes(folder / "a.ply");
  for (size_t length = 0; length < bytes.size(); ++length) {
    write_bytes(folder / "cut.ply", bytes.substr(0, length));
    expect_input_error([&] { read_ply(folder / "cut.ply"); }, {"cut.ply"});
  }
}

TEST(Ply, HeadersThatAreNone) {
  const TemporaryFolder folder;
  const std::vector<std::string> bad{
      "",
      "PLY\n",
      "ply\nend_header\n",
      "ply\nformat text 1.0\nend_header\n",
      "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n",
      "ply\nformat ascii 1.0\nelement vertex many\nend_header\n",
      "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\none\n"};
  for (const std::string& bytes : bad) {
    write_bytes(folder / "bad.ply", bytes);
    expect_input_error([&] { read_ply(folder / "bad.ply"); }, {"bad.ply"});
  }
}

}  // namespace
}  // namespace tessera
