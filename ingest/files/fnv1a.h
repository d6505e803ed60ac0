// The 64-bit FNV-1a hash (Fowler, Noll, Vo) of source files, stage keys and fingerprints. It
// detects changes and is not cryptographic.
#pragma once
#include <fmt/format.h>
#include <filesystem>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tessera {

class Fnv1a {
 public:
  void add(const void* bytes, size_t count) {
    const auto* p = static_cast<const unsigned char*>(bytes);
    for (size_t i = 0; i < count; ++i) hash_ = (hash_ ^ p[i]) * 0x100000001b3u;
  }
  void add(std::string_view text) { add(text.data(), text.size()); }
  uint64_t value() const { return hash_; }
  /// 16 hexadecimal digits.
  std::string hex() const { return fmt::format("{:016x}", hash_); }

 private:
  uint64_t hash_ = 0xcbf29ce484222325u;
};

inline constexpr size_t kHashedBlock = 1 << 16;  // bytes

/// 16 hexadecimal digits. Errors: InputError when the file cannot be read.
std::string source_hash(const std::filesystem::path& file);

/// 16 hexadecimal digits of `blocks` (two or more) of so many bytes, spread over the file, both
/// ends among them: tells two large files apart at once. Errors: as source_hash.
std::string sampled_hash(const std::filesystem::path& file, int64_t blocks = 16,
                         size_t bytes = kHashedBlock);

}  // namespace tessera
