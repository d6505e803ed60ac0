// Fuzz target: the reader of .sog on arbitrary bytes. Entries of archives are mutated one at a
// time, and the archive gets their new checksums. See scripts/fuzz.sh.
#include <algorithm>

#include "ingest/files/stored_zip.h"
#include "static3d/formats/splat_file.h"
#include "tests/fuzz/hostile_file.h"

extern "C" {

size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return tessera::testing::read_hostile(data, size, ".sog",
                                        [](const auto& path) { tessera::load_splat_file(path); });
}

size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  const std::string file(reinterpret_cast<const char*>(data), size);
  std::vector<tessera::ZipEntry> entries;
  try {
    if (seed % 8 != 0)
      for (const auto& [name, bytes] : tessera::zip_contents(file, "seed"))
        entries.push_back({name, std::string(bytes)});
  } catch (const tessera::InputError&) {
    entries.clear();
  }
  if (entries.empty()) return LLVMFuzzerMutate(data, size, most);
  std::string& bytes = entries[seed / 8 % entries.size()].bytes;
  const size_t before = bytes.size();
  bytes.resize(before + 64);
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), before, bytes.size()));
  const std::string archive = tessera::stored_zip(entries);
  if (archive.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(archive.begin(), archive.end(), data);
  return archive.size();
}
}
