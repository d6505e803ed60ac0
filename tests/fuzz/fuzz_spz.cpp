// Fuzz target: the reader of .spz, versions 2 to 4, on arbitrary bytes. Compressed files are
// mutated after decompression. See scripts/fuzz.sh.
#include <algorithm>

#include "ingest/files/gzip.h"
#include "static3d/formats/splat_file.h"
#include "tests/fuzz/hostile_file.h"

extern "C" {

size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".spz",
                                        [](const auto& path) { tessera::load_splat_file(path); });
}

/// Bits of a gzip stream that change make its checksum wrong: unpacks, changes and packs.
size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  const std::string file(reinterpret_cast<const char*>(data), size);
  std::string plain;
  try {
    if (seed % 8 != 0 && tessera::is_gzip(file)) plain = tessera::gunzip(file, 1 << 20, "seed");
  } catch (const tessera::InputError&) {
    plain.clear();
  }
  if (plain.empty()) return LLVMFuzzerMutate(data, size, most);
  const size_t before = plain.size();
  plain.resize(before + 64);
  plain.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(plain.data()), before, plain.size()));
  const std::string packed = tessera::gzip(plain);
  if (packed.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(packed.begin(), packed.end(), data);
  return packed.size();
}
}
