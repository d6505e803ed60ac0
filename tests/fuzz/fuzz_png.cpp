// Fuzz target: the readers of .png on arbitrary bytes. What is decoded without libpng must have the
// pixels that libpng gives. Rows are mutated inflated, and the file gets new checksums. See
// scripts/fuzz.sh.
#include "ingest/files/png.h"

#include <zlib.h>

#include <algorithm>

#include "ingest/files/plain_png.h"
#include "tests/fuzz/hostile_file.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

namespace tessera::testing {
namespace {

constexpr size_t kHeaderEnd = 33;       // of signature and IHDR
constexpr size_t kMostBytes = 1 << 16;  // of the rows that are mutated

using Bytes = std::vector<uint8_t>;

Bytes chunk(const char* type, const Bytes& data) {
  Bytes covered(type, type + 4), all;
  covered.insert(covered.end(), data.begin(), data.end());
  const auto add = [&](uint32_t value) {
    for (const int shift : {24, 16, 8, 0}) all.push_back(uint8_t(value >> shift));
  };
  add(uint32_t(data.size()));
  all.insert(all.end(), covered.begin(), covered.end());
  add(uint32_t(crc32(0, covered.data(), uInt(covered.size()))));
  return all;
}

/// The rows of the first IDAT with their filters; none where it is damaged.
Bytes first_rows(const uint8_t* file, size_t size) {
  constexpr char kType[] = "IDAT";
  const uint8_t* const end = file + size;
  const uint8_t* const type = std::search(file, end, kType, kType + 4);
  if (end - type < 4) return {};
  Bytes rows(kMostBytes);
  uLongf count = rows.size();
  if (uncompress(rows.data(), &count, type + 4, uLong(end - type - 4)) != Z_OK) return {};
  rows.resize(count);
  return rows;
}

Bytes with_rows(const uint8_t* file, const Bytes& rows) {
  Bytes stream(compressBound(rows.size()));
  uLongf count = stream.size();
  compress(stream.data(), &count, rows.data(), rows.size());
  stream.resize(count);
  const Bytes header = chunk("IHDR", {file + 16, file + 29});
  Bytes all(file, file + 8);
  for (const Bytes& part : {header, chunk("IDAT", stream), chunk("IEND", {})})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// A suggested palette makes a file one that libpng reads.
Bytes with_palette(const uint8_t* file, size_t size) {
  const Bytes palette = chunk("PLTE", {1, 2, 3});
  Bytes all(file, file + size);
  all.insert(all.begin() + kHeaderEnd, palette.begin(), palette.end());
  return all;
}

}  // namespace
}  // namespace tessera::testing

extern "C" {

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace tessera::testing;
  Bytes file(data, data + size);
  const std::optional<tessera::Image8> plain = tessera::decode_plain_png(file);
  if (!plain)
    return read_hostile(data, size, ".png", [](const auto& path) { tessera::read_png(path); });
  file = with_palette(data, size);
  bool is_same = false;
  read_hostile(file.data(), file.size(), ".png",
               [&](const auto& path) { is_same = tessera::read_png(path).data == plain->data; });
  if (!is_same) std::abort();
  return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  using namespace tessera::testing;
  Bytes rows = size > kHeaderEnd && seed % 8 != 0 ? first_rows(data, size) : Bytes();
  if (rows.empty()) return LLVMFuzzerMutate(data, size, most);
  const size_t bytes = rows.size();
  if (seed % 8 == 1)
    LLVMFuzzerMutate(data + 16, 13, 13);  // size and kind
  else
    LLVMFuzzerMutate(rows.data(), bytes, bytes);
  const Bytes file = with_rows(data, rows);
  if (file.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(file.begin(), file.end(), data);
  return file.size();
}
}
