// Hashes a file block by block.

#include <fmt/format.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"

namespace tessera {

std::string source_hash(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           std::fclose);
  Fnv1a hash;
  unsigned char block[1 << 16];
  while (in != nullptr) {
    const size_t count = std::fread(block, 1, sizeof block, in.get());
    hash.add(block, count);
    if (count < sizeof block) break;
  }
  if (in == nullptr || std::ferror(in.get()) != 0)
    throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions",
                                 file.string(), std::strerror(errno)));
  return hash.hex();
}

}  // namespace tessera
