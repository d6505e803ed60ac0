// Mutates the entries of a zip archive one at a time, and gives the archive their new checksums:
// its reader looks at what they hold. Included once by a fuzz target.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"

extern "C" {

size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

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
