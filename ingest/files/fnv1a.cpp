// Hashes a file block by block.

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"

namespace tessera {

namespace {

/// Hands over the file's blocks of so many bytes at `places`, from its begin; the whole file where
/// there are none.
void read_blocks(const std::filesystem::path& file, const std::vector<int64_t>& places,
                 size_t bytes, Fnv1a& hash) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           std::fclose);
  std::vector<unsigned char> block(bytes);
  for (size_t i = 0; in != nullptr && (places.empty() || i < places.size()); ++i) {
    if (!places.empty() && std::fseek(in.get(), long(places[i]), SEEK_SET) != 0) break;
    const size_t count = std::fread(block.data(), 1, bytes, in.get());
    hash.add(block.data(), count);
    if (places.empty() && count < bytes) break;
  }
  if (in == nullptr || std::ferror(in.get()) != 0)
    throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions",
                                 file.string(), std::strerror(errno)));
}

}  // namespace

std::string source_hash(const std::filesystem::path& file) {
  Fnv1a hash;
  read_blocks(file, {}, kHashedBlock, hash);
  return hash.hex();
}

std::string sampled_hash(const std::filesystem::path& file, int64_t blocks, size_t bytes) {
  std::error_code unread;  // is said when it is opened
  const auto size = int64_t(std::filesystem::file_size(file, unread));
  const int64_t last = unread ? 0 : std::max<int64_t>(0, size - int64_t(bytes));
  std::vector<int64_t> places;
  for (int64_t i = 0; i < blocks; ++i) places.push_back(i * last / (blocks - 1));
  Fnv1a hash;
  read_blocks(file, places, bytes, hash);
  return hash.hex();
}

}  // namespace tessera
